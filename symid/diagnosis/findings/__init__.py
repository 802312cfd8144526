"""Results of a selection: the gap on held-out data, where it lies, verdict, values, faults of the recording."""
