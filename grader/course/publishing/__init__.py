"""Output of the class database: result files, exports for platforms, comparison of two gradings, grades that cannot be right."""
