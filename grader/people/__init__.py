"""Who hands in: names, sections, dates, and what is set beside the marks by hand or by lateness."""
