"""Tests of the judge of attacks itself: it must report an attack that succeeds, or `held` would mean nothing."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import nullcontext, suppress

import pytest

from grader.sandbox.isolation_levels import NO_ISOLATION
from tests.hostile import __main__, outputs
from tests.hostile.decoys import SECRET, below
from tests.hostile.judging import AttackJudge
from tests.hostile.program import FILTER, Program, in_method, last, sound

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks for leftovers in /proc")


ESCAPES = """
if not hasattr(LowPassFilter, "done"):
    LowPassFilter.done = True
    import ctypes, os, signal, socket
    open("@TARGET@", "a").write("owned")
    open("@FOLDER@/new", "w").write("owned")
    socket.create_connection(("127.0.0.1", @PORT@), 2)
    socket.socket(socket.AF_UNIX).connect("\\0@ABSTRACT@")
    ctypes.CDLL(None).shmget(@IPC@, 4096, 0o1600)
    os.kill(@PID@, signal.SIGKILL)
    if os.fork() == 0:
        os.setsid()
        for fd in range(64):
            try: os.close(fd)
            except OSError: pass
        signal.alarm(20)
        signal.pause()
raise RuntimeError(open("@SECRET@").read())
"""


@pytest.fixture
def no_descendants() -> Iterator[None]:
    """Whatever a test lets out is ended with it: the other courts would see it, too."""
    before = below(os.getpid())
    yield
    for pid in below(os.getpid()) - before:
        with suppress(ProcessLookupError, ChildProcessError):  # it has just ended by itself
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)


@pytest.mark.usefixtures("no_descendants")
def test_everything_that_an_escape_touches_is_seen_where_nothing_is_held() -> None:
    files = last(sound(), FILTER, in_method("LowPassFilter", "update", ESCAPES))
    with AttackJudge(NO_ISOLATION.name) as unwalled:
        troubles = unwalled.try_(Program("made-up", "escape", files, only="filtering")).troubles
    assert "report.html: it holds what the decoys hold" in troubles
    assert "result.json: it holds what the decoys hold" in troubles
    assert [trouble for trouble in troubles if "it holds" not in trouble] == [
        "the listener PORT was reached",
        "the listener ABSTRACT was reached",
        "the decoy process was ended",
        "shared memory or a queue changed",
        "the decoy new changed",
        "the decoy target.txt changed",
        "2 processes are left over",  # a part that raises is run again beside the sheet's own reader
    ]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("result.json", f'{{"notes": ["{SECRET}"]}}'),
        ("result.json", '{"notes": ["\\ud800"]}'),
        ("gradescope", '{"tests": [{"output": "\\u001b[2J"}]}'),
        ("report.html", "<p><script>alert(1)</script>"),
        ("report.html", '<p onmouseover="alert(1)">'),
        ("index.html", '<a href="javascript:alert(1)">x</a>'),
        ("index.html", "<script>alert(1)</script><script>alert(2)</script>"),
        ("moodle.csv", "Identifier,Feedback comments\r\nParticipant 1,<b>x</b>\r\n"),
        ("gradescope.csv", "First name\r\n=1+1\r\n"),
        ("gradebook.csv", 'id,name\r\none,"@SUM(1)"\r\n'),
        ("the terminal", "\x1b[31mred"),
        ("github", "::error file=a.py::x\n::stop-commands::y"),
        ("junit", "<testsuites><owned/></testsuites>"),
        ("github aside", "\u202eevil"),
    ],
)
def test_what_is_not_escaped_is_seen(name: str, text: str) -> None:
    assert list(outputs.problems(name, text))


def test_the_whole_corpus_is_not_run_where_nothing_holds_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(SystemExit):
        __main__.main(["--isolation", NO_ISOLATION.name, "--only", "no attack has this name"])
    assert "invalid choice" in capsys.readouterr().err
    opened: list[str] = []
    monkeypatch.setattr(__main__, "AttackJudge", lambda level: nullcontext(opened.append(level)))
    assert __main__.main(["--only", "no attack has this name"]) == 0
    assert opened
    assert NO_ISOLATION.name not in opened
