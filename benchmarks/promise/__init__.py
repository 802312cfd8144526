"""Random logs of known truth for `benchmarks.ok_promise`, by a simulator that shares no code with symid."""
