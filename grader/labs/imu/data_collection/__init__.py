"""The criterion Data collection: facts, hypotheses and checks."""
