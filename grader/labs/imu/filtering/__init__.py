"""The criterion *Filtering*: judges the sheet's exponential moving average, which reduces noise and preserves the signal."""
