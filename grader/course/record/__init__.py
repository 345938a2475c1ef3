"""The durable record of a class: results, settings, decisions of people, submitted files."""
