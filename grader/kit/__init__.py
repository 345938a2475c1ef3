"""Build what an instructor gives out: starter files and a wheel for students, CI jobs and an autograder for platforms.

None of it holds the reference solution, a seed or, but for Gradescope where students cannot read them, hidden traces.
"""
