"""Results as HTML files that need nothing beside them."""
