"""The four extensions of the sheet: complementary filter, Allan deviation, all IMUs of a model, live plot."""
