"""Outputs of an axis predicted from the motion that a log records, with the weights of their errors."""
