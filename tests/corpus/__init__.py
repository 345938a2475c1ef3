"""Submissions as students write them: sound ones in many styles, faulty ones with one fault each, and broken ones.

Nothing here imports the grader, and the grader imports nothing of this: the corpus says what a fair marker would say.
"""
