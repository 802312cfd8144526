"""Faults of recorders, logs and structure that contradict an estimate."""
