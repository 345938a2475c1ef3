"""The criterion Sensor access: facts, hypotheses and checks."""
