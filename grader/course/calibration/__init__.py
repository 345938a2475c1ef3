"""Calibration: a sample that a person marks by hand, the comparison of those marks with the grader's points, and a proposal."""
