"""The review desk: a local web application for people who review a graded class. The extra `desk` installs what it needs."""
