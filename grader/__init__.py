"""imugrade: the autograder for Lab 04-01, *Reading IMU data in MuJoCo*."""

__version__ = "0.1.0"
