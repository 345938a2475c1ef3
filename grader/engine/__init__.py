"""Grade one submission, whatever the lab: sandbox sessions, checks, feedback, rubric, results and ground truth."""
