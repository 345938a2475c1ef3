"""The grader's own sound versions (stand-ins) of functions that a student got wrong, so that other criteria can be judged.

They are sent into the sandbox as text, after the checks of the wrong function. Each says no more than the lab sheet itself.
"""
