"""Tests of what judges: pure functions, arrays in and findings out, without a sandbox."""
