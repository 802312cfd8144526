"""Filters, differences, resampling and power densities of sampled signals."""
