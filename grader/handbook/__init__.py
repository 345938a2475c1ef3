"""The handbook: pages that ship with the package, made from the code where they can be. `python -m grader.handbook` makes
them anew; a test holds them to it.
"""
