"""Lab-independent grading of one submission: sessions, checks, findings, feedback, rubric, results and traces."""
