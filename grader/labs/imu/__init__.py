"""The lab "Reading IMU data in MuJoCo" (04-01): what the grading engine needs to grade this one lab."""
