"""The one criterion of the toy lab."""
