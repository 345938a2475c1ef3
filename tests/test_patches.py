"""Unified diffs of one file: what is made is applied back exactly, and what does not fit exactly is refused."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grader.base.errors import RequestError
from grader.course.record.patches import LARGEST, apply_patch, diff_of

pytestmark = pytest.mark.quick
BEFORE = b"a\nb\nc\nd\ne\nf\ng\nh\ni\nj\nk\nl\n"


@given(
    st.lists(st.sampled_from([b"a", b"b\r", b"", b"\xff", "ä\x0c".encode()]), max_size=12).map(b"\n".join), st.data()
)
def test_what_is_made_is_applied_back(before: bytes, data: st.DataObject) -> None:
    after = data.draw(st.lists(st.sampled_from([b"a", b"b\r", b"x", b"\xfe"]), max_size=12).map(b"\n".join))
    diff = diff_of("f.py", before, after)
    assert (apply_patch(before, diff) if diff else before) == after


def test_a_diff_reads_as_diff_u_writes_it_and_what_git_writes_above_it_is_passed_over() -> None:
    diff = diff_of("f.py", b"one\ntwo", b"one\n2\n")
    assert diff == "--- a/f.py\n+++ b/f.py\n@@ -1,2 +1,2 @@\n one\n-two\n\\ No newline at end of file\n+2\n"
    assert apply_patch(b"a\nb\n", f"{HEAD}@@ -1,0 +2 @@\n+x\n") == b"a\nx\nb\n"  # as `diff -U0` writes an insertion
    assert apply_patch(b"one\ntwo", f"diff --git a/f.py b/f.py\nindex 1..2 100644\n{diff}") == b"one\n2\n"


HEAD = "--- a/f.py\n+++ b/f.py\n"
REFUSED = {
    "no diff": ("c -> C", "not a unified diff"),
    "another line there": (f"{HEAD}@@ -3 +3 @@\n-x\n+C\n", "the lines from 3 on do not match"),
    "a line further down": (f"{HEAD}@@ -4 +4 @@\n-c\n+C\n", "the lines from 4 on do not match"),
    "beyond the end": (f"{HEAD}@@ -99 +99 @@\n-c\n+C\n", "the lines from 99 on do not match"),
    "hunks out of order": (f"{HEAD}@@ -4 +4 @@\n-d\n+D\n@@ -3 +3 @@\n-c\n+C\n", "the lines from 3 on do not match"),
    "a count that is wrong": (f"{HEAD}@@ -3,2 +3 @@\n-c\n+C\n", "line 6: the hunk has other lines"),
    "a hunk that is cut short": (f"{HEAD}@@ -3 +3 @@\n-c\n", "line 5: the hunk has other lines"),
    "text between hunks": (f"{HEAD}@@ -3 +3 @@\n-c\n+C\nrm -rf\n", "line 6: no hunk"),
    "too large": (HEAD + "x" * LARGEST, "more than 1000000 bytes"),
}


@pytest.mark.parametrize(("diff", "said"), REFUSED.values(), ids=REFUSED)
def test_what_does_not_fit_exactly_is_refused(diff: str, said: str) -> None:
    with pytest.raises(RequestError, match=said):
        apply_patch(BEFORE, diff)
