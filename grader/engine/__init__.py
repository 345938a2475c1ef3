"""One submission, without a lab in it: marking, examination, conversation, findings, words, rubric, results, traces."""
