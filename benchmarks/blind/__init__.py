"""Axes with one hidden effect, diagnosed from their logs alone: see `python -m benchmarks.blind --help`."""
