"""What users call: an axis, its name or file, or a model, with logs, files or data frames, everywhere alike."""
