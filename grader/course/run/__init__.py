"""A run of `imugrade grade`: submissions found, graded, recorded, with warnings."""
