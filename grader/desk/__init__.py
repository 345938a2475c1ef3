"""The review desk: a local web application over the record of a graded class. What it needs comes with the extra `desk`."""
