"""Changes of grades without running code: overrides, decisions on groups of submissions, another rubric."""
