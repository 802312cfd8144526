"""Results as self-contained HTML files."""
