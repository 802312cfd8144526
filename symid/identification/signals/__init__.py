"""Signals of an axis among the columns of a log."""
