"""The next experiment: candidate motions, their discrimination between rival causes, and their simulation."""
