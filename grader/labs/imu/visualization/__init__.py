"""The criterion *Visualization*: judges the plots that the submission draws of the sensor data, and of raw and filtered data."""
