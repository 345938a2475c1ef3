"""What a test says when a generated file is stale."""

STALE = "if the change is meant, run python -m tests.regenerate, read the difference and commit it"
