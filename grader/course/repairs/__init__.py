"""Repairs, which are patches on submitted files: made by people, suggested by the grader, and kept through a regrade."""
