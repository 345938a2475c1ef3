"""Lab 04-01, Reading IMU data in MuJoCo."""
