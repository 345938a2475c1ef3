"""Other grades without running code: overrides, decisions on groups, another rubric."""
