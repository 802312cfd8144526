"""Design of the next experiment, which discriminates between two rival causes.

`candidates` lists motions, `discrimination` ranks them by the expected odds, `simulated` simulates the best with its
controller, and `design` chooses.
"""
