"""A model with values under a record, and weighted least squares of the errors that it leaves."""
