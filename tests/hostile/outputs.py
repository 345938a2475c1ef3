"""Everything that the grader writes about a submission, and what in it a hostile text has got through to."""

from __future__ import annotations

import csv
import io
import json
import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from html.parser import HTMLParser
from xml.etree import ElementTree

from rich.console import Console

from grader.evidence import unpacked
from grader.formats import github, moodle
from grader.formats.classroom50 import Identity, classroom50
from grader.formats.gradebook import gradebook
from grader.formats.gradescope import gradescope
from grader.formats.gradescope_csv import gradescope_csv
from grader.formats.junit import junit
from grader.formats.places import Places
from grader.formats.prairielearn import prairielearn
from grader.people.standing import HandIn, Person, Standing
from grader.report import terminal
from grader.report.pages import index_page, report_page
from grader.results import Result, to_json
from tests import made_up
from tests.hostile.bait import SECRET

_IDENTITY = Identity.of(
    {
        "CLASSROOM": "cs",
        "ASSIGNMENT": "imu",
        "SUBMISSION_TAG": "submit/2026-11-01T10-00-00Z-abc1234",
        "COMMIT_URL": "https://example.org/c",
        "RELEASE_URL": "https://example.org/r",
        "OWNER": "alice",
    }
)
_JOINERS = "\u200c\u200d"
_COMMAND = re.compile(r"::(error|warning|notice) ([a-z]+=[^:,]*,?)+::[^\n]*")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def _on_terminal(result: Result) -> str:
    out = io.StringIO()
    terminal.show(result, Console(file=out, width=100, highlight=False, markup=False, emoji=False))
    return out.getvalue()


def _standing(result: Result) -> Standing:
    """A platform hands over names as they came; here that of the submission, which may be poisoned, stands for all."""
    person = Person(*[result.submission] * 5)
    return Standing("one", result, HandIn((person,), submitted=result.submission))


WRITERS: Mapping[str, Callable[[Result], str]] = {
    "result.json": to_json,
    "report.html": lambda result: report_page(_standing(result), unpacked(result.evidence.charts)),
    "index.html": lambda result: index_page({"one": _standing(result)}, {"one": result.evidence.fingerprint}),
    "gradebook.csv": lambda result: gradebook({"one": _standing(result)}),
    "gradescope.csv": lambda result: gradescope_csv({"one": _standing(result)}),
    "moodle comment": lambda result: moodle.comment(_standing(result)),
    "the terminal": _on_terminal,
    "github commands": lambda result: github.commands(result, Places()),
    "github summary": github.summary,
    "gradescope": lambda result: gradescope(result, hidden=False, visibility="visible"),
    "classroom50": lambda result: classroom50(result, _IDENTITY, "2026-11-01T10:00:00Z"),
    "junit": junit,
    "prairielearn": lambda result: prairielearn(result, hidden=False),
}


def troubles(result: Result) -> list[str]:
    """What is wrong with the outputs of one result; empty if nothing is."""
    unjudged = result.status == "incomplete"  # not every platform has a word for that
    writers = {
        name: write
        for name, write in WRITERS.items()
        if not unjudged or name in ("result.json", "report.html", "index.html")
    }
    return [f"{name}: {problem}" for name, write in writers.items() for problem in problems(name, write(result))]


def problems(name: str, text: str) -> Iterator[str]:
    if SECRET in text:
        yield "it holds what the decoys hold"
    yield from _raw(text)
    look = {
        "result.json": _in_json,
        "gradescope": _in_json,
        "classroom50": _in_json,
        "prairielearn": _in_json,
        "report.html": _in_page,
        "index.html": _in_index,
        "moodle comment": _in_page,
        "gradebook.csv": _in_csv,
        "gradescope.csv": _in_csv,
        "github commands": _in_commands,
        "junit": _in_xml,
    }.get(name)
    if look is not None:
        yield from look(text)


def _raw(text: str) -> Iterator[str]:
    """Characters that move the cursor, hide or reorder what is written: none may come through as itself."""
    bad = {
        c for c in text if unicodedata.category(c) in {"Cc", "Cf", "Cs", "Zl", "Zp"} and c not in _JOINERS + "\n\t\r"
    }
    if bad:
        yield f"it holds {', '.join(sorted(f'U+{ord(c):04X}' for c in bad))}"


def _in_json(text: str) -> Iterator[str]:
    record = json.loads(text)
    if isinstance(record, dict):
        record.pop("submission", None)  # the contract: it keeps the original
    for value in _strings(record):
        yield from _raw(value)


def _strings(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from (*_strings(key), *_strings(item))
    elif isinstance(value, list):
        for item in value:
            yield from _strings(item)


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.bad: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        harmful = {"script", "iframe", "object", "embed", "img", "link", "base", "form", "input", "marquee", "b", "i"}
        if tag == "img" and re.fullmatch(r"data:image/png;base64,[\w+/=]+", dict(attrs).get("src") or ""):
            return  # a handed-in picture, set anew by the grader
        if tag in harmful:
            self.bad.append(f"a <{tag}>")
        self.bad += [f"an attribute {name}" for name, _ in attrs if name.startswith("on")]
        self.bad += [f"{name}={value}" for name, value in attrs if name in ("href", "src") and ":" in (value or "")]


def _in_page(text: str) -> Iterator[str]:
    page = _Page()
    page.feed(text)
    yield from page.bad


def _in_index(text: str) -> Iterator[str]:
    """The page of the class has a script and a form of its own, so it is held against that of a harmless result."""
    own = Counter(_in_page(WRITERS["index.html"](made_up.result(name="harmless"))))
    yield from (Counter(_in_page(text)) - own).elements()


def _in_csv(text: str) -> Iterator[str]:
    for row in csv.reader(io.StringIO(text)):
        for cell in row:
            if cell.startswith(_FORMULA) and not re.fullmatch(r"-?\d+(\.\d+)?", cell):
                yield f"a formula {cell[:40]!r}"


def _in_commands(text: str) -> Iterator[str]:
    for line in text.splitlines():
        if not _COMMAND.fullmatch(line):
            yield f"a line that is no command of ours: {line[:80]!r}"


def _in_xml(text: str) -> Iterator[str]:
    tags = {element.tag for element in ElementTree.fromstring(text).iter()}
    if more := tags - {
        "testsuites",
        "testsuite",
        "testcase",
        "failure",
        "error",
        "skipped",
        "properties",
        "property",
        "system-out",
    }:
        yield f"elements {sorted(more)}"
