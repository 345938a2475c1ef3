"""Sound stand-ins, sent into the sandbox in place of a part that a student's own version gets wrong.

They go over the wire as text, and only after the checks of that part are over. Each says no more than the lab sheet itself.
"""
