"""Damaged logs: what can be wrong with a file, and what `symid identify` makes of it."""
