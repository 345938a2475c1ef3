"""Calibration: people mark a sample by hand, their marks are compared with the grades, and better deductions are proposed."""
