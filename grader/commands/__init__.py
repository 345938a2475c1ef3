"""One module a command, each a thin layer of words over what does the work. Nothing heavy is imported until one runs."""
