"""Errors of the parameters beyond those by white noise: bias, scatter, what the model lacks."""
