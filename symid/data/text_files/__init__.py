"""Files of text as tables: their layout, numbers, times, and the names and units of their columns."""
