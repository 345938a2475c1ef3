"""The criterion Data collection: facts about a student's `simulate_and_collect`, their diagnosis, and the checks."""
