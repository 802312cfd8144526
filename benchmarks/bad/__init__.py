"""Bad options, bad JSON and bad tables for the command line."""
