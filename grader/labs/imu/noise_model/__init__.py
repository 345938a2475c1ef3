"""Noise model: white Gaussian noise of the size that is asked for, and a constant bias, independent on every axis."""
