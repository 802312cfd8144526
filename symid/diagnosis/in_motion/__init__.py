"""The gap as its user sees it: the explained axis simulated along the log."""
