"""Files written from the record: the pages of OUT, exports and comparisons, and the contradictions found in them."""
