"""Mutants of the reference: small faults, made by rule, each of which must lose points."""
