"""A run of `imugrade grade`: submissions are found, graded and stored, with warnings at the end."""
