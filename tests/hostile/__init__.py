"""Programs that attack the grader, and the proof that none gains anything by it: `python -m tests.hostile`.

Every program is harmless, also where nothing isolates it and root runs it: processes, memory, disk and time are bounded, the
network is this machine's loopback, and what is read, written, deleted or signalled outside is a decoy that the run itself made.
"""
