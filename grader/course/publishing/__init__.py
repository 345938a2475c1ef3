"""Files written from the class database: pages and results, exports for platforms, comparisons, and contradictions in them."""
