"""Labs for the tests."""
