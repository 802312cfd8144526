"""Signals that are recorded early or late against each other."""
