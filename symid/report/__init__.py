"""Results as tables and JSON records, as figures and as pages."""
