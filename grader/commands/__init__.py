"""Command line: one module per command, each a thin layer of options and messages. Heavy imports wait until a command runs."""
