"""The next experiment: candidate motions, how well each discriminates between rival causes, and its simulation."""
