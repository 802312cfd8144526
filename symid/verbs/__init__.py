"""The Python interface: every verb takes an axis, its name or file, or a model, and logs, files or data frames."""
