"""A class from what was handed in to what is uploaded: grading, publishing, points by hand, comparing two runs."""
