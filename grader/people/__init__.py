"""Students, rosters and dates, and what overrides and lateness add to the automatic points."""
