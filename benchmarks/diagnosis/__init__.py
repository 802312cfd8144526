"""Diagnoses of real logs and of the failures of other tools."""
