"""A class from what was handed in to what is uploaded: grading, publishing, overrides, comparing two runs."""
