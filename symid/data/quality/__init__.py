"""The clock of a log, and checks of its channels: lost samples, stuck and clipped spans, jumps."""
