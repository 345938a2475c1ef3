"""Visualization: labelled plots of the sensor data, and of raw and filtered data, judged by the figures that the code draws."""
