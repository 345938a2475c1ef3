"""The criterion Sensor access: facts about a student's `get_imu_readings` (the reader), their diagnosis, and the checks."""
