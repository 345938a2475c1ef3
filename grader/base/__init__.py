"""Basics that all packages of the grader share: errors, untrusted text, atomic file writes, CSV tables, timestamps."""
