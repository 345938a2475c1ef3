"""A whole class, from the submissions to the uploaded grades: grading, overrides, repairs, calibration, publishing."""
