"""The class database, one SQLite file: results, settings, decisions of people, repairs and submitted files."""
