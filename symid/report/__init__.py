"""Results as text, JSON records and figures."""
