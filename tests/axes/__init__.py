"""Axes that every check is crossed with, each beside its matrices written by hand."""
