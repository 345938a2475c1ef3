"""What is written from the record: the files of OUT, exports, comparisons, and contradictions in them."""
