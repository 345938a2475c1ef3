"""Students, rosters and dates, and how overrides, repairs and lateness change the automatic points."""
