"""Simulation of declared axes: trajectories, controllers, dynamics and the engine that runs them."""
