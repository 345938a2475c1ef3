"""What strangers write, mangled: no exception but the documented ones, no memory beyond the caps."""
