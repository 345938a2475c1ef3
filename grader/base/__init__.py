"""Shared basics: errors, untrusted text, atomic file writes, timestamps."""
