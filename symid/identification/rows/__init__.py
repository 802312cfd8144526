"""Rows of the observation: signals filtered, differentiated, put into the regressor and thinned."""
