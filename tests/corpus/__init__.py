"""Submissions as students write them: sound ones in many styles, faulty ones with one fault each, and broken ones.

`cases.py` explains the tables. Nothing of the grader is imported to read them: the corpus says what a fair marker would say.
"""
