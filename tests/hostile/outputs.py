"""Everything that the grader writes about a submission, and what in it a hostile text has got through to."""

from __future__ import annotations

import csv
import io
import json
import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

from rich.console import Console

from grader.base.errors import GraderError
from grader.engine.chart_data import unpacked
from grader.engine.results import Result, to_json
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade, HandIn, Person
from grader.platforms import registry
from grader.platforms.platform import Platform, ResultContext, Template
from grader.report import terminal
from grader.report.pages import index_page, report_page
from tests import fake_results
from tests.hostile.decoys import SECRET
from tests.pages import Page

ENVIRONMENT = {
    "CLASSROOM": "cs",
    "ASSIGNMENT": "imu",
    "SUBMISSION_TAG": "submit/2026-11-01T10-00-00Z-abc1234",
    "COMMIT_URL": "https://example.org/c",
    "RELEASE_URL": "https://example.org/r",
    "OWNER": "alice",
}
TEMPLATES = {  # what a platform exports to be filled in, with a row for the person 1
    "canvas": b"Student,ID,SIS Login ID,Section,Lab (7)\r\nAlice,1,,A,\r\n",
    "moodle": b"Identifier,Grade,Last modified (grade),Feedback comments\r\nParticipant 1,,,\r\n",
}
_JOINERS = "\u200c\u200d"
_COMMAND = re.compile(r"::(error|warning|notice) ([a-z]+=[^:,]*,?)+::[^\n]*")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def _on_terminal(result: Result) -> str:
    out = io.StringIO()
    screen = Console(file=out, width=100, highlight=False, markup=False, emoji=False)
    for line in terminal.screen(result, screen, LAB):
        terminal.show_line(line, screen)
    return out.getvalue()


def _standing(result: Result) -> FinalGrade:
    """A platform hands over names as they came; here that of the submission, which may be poisoned, stands for all."""
    person = Person(*[result.submission] * 5)
    return FinalGrade("one", result, HandIn((person,), submitted=result.submission))


def _of_platform(platform: Platform) -> Iterator[tuple[str, Callable[[Result], str]]]:
    """What a job on the platform writes, and what the platform is given of a class."""
    handed = ResultContext(LAB, fake_results.submission("one"), Path(), ENVIRONMENT)
    if (respond := platform.respond) is not None:
        yield platform.name, lambda result: respond(result, handed)
    if (aside := platform.aside) is not None:
        yield f"{platform.name} aside", lambda result: aside.text(result, handed)
    if (write := platform.write) is not None:
        yield platform.gradebook, lambda result: write({"one": _standing(result)}, (), "").decode("utf-8-sig")
    if platform.fill is not None:
        yield platform.gradebook, partial(_filled, platform)


def _filled(platform: Platform, result: Result) -> str:
    assert platform.fill is not None
    final_grade = FinalGrade("one", result, HandIn((Person("Alice", "1", platform.name),)))
    filled = platform.fill(Template(TEMPLATES[platform.name], "template.csv"), {"one": final_grade})
    assert {match.id for match in filled.placed} == {"one"}
    return filled.data.decode("utf-8-sig")


WRITERS: Mapping[str, Callable[[Result], str]] = {
    "result.json": to_json,
    "report.html": lambda result: report_page(_standing(result), unpacked(result.evidence.charts)),
    "index.html": lambda result: index_page({"one": _standing(result)}, {"one": result.evidence.fingerprint}),
    "the terminal": _on_terminal,
    **dict(row for platform in registry.platforms(*registry.DEEDS) for row in _of_platform(platform)),
}


def troubles(result: Result) -> list[str]:
    """What is wrong with the outputs of one result; empty if nothing is."""
    found = []
    for name, write in WRITERS.items():
        try:
            found += [f"{name}: {problem}" for problem in problems(name, write(result))]
        except GraderError:
            if result.status != "incomplete":  # not every platform has a word for that
                raise
    return found


def problems(name: str, text: str) -> Iterator[str]:
    if SECRET in text:
        yield "it holds what the decoys hold"
    yield from _raw(text)
    yield from LOOKS[name](text)


def _raw(text: str) -> Iterator[str]:
    """Characters that move the cursor, hide or reorder what is written: none may come through as itself."""
    bad = {c for c in set(text) if unicodedata.category(c) in {"Cc", "Cf", "Cs", "Zl", "Zp"} and c not in _JOINERS + "\n\t\r"}
    if bad:
        yield f"it holds {', '.join(sorted(f'U+{ord(c):04X}' for c in bad))}"


def _in_json(text: str) -> Iterator[str]:
    record = json.loads(text)
    if isinstance(record, dict):
        record.pop("submission", None)  # the contract: it keeps the original
    yield from _raw(_all_text(record))


def _all_text(value: object) -> str:
    if isinstance(value, dict):
        return _all_text([*value, *value.values()])
    return "".join(map(_all_text, value)) if isinstance(value, list) else value if isinstance(value, str) else ""


_HARMFUL = {"script", "iframe", "object", "embed", "img", "link", "base", "form", "input", "marquee", "b", "i"}
_PICTURE = r"data:image/png;base64,[\w+/=]+"
"""A handed-in picture, set anew by the grader."""


def _in_page(text: str) -> Iterator[str]:
    page = Page(text)
    yield from (f"a script: {data}" for tag, data in page.texts if tag == "script")
    for tag, attributes in page.tags:
        if tag == "img" and re.fullmatch(_PICTURE, attributes.get("src") or ""):
            continue
        if tag in _HARMFUL:
            yield f"a <{tag}>"
        yield from (f"an attribute {name}" for name in attributes if name.startswith("on"))
        yield from (f"{name}={attributes[name]}" for name in ("href", "src") if ":" in (attributes.get(name) or ""))


def _in_page_of_ours(name: str, text: str) -> Iterator[str]:
    """A page has a script of its own, that of the class a form: it is held against that of a harmless result."""
    own = Counter(_in_page(WRITERS[name](fake_results.result(name="harmless"))))
    yield from (Counter(_in_page(text)) - own).elements()


def _cells(text: str) -> list[str]:
    return [cell for row in csv.reader(io.StringIO(text)) for cell in row]


def _in_csv(text: str) -> Iterator[str]:
    for cell in _cells(text):
        if cell.startswith(_FORMULA) and not re.fullmatch(r"-?\d+(\.\d+)?", cell):
            yield f"a formula {cell[:40]!r}"


def _in_worksheet(text: str) -> Iterator[str]:
    """Moodle reads its cells as HTML."""
    yield from _in_csv(text)
    for cell in _cells(text):
        yield from _in_page(cell)


def _in_commands(text: str) -> Iterator[str]:
    for line in text.splitlines():
        if not _COMMAND.fullmatch(line):
            yield f"a line that is no command of ours: {line[:80]!r}"


def _in_xml(text: str) -> Iterator[str]:
    own = {"testsuites", "testsuite", "testcase", "failure", "error", "skipped", "properties", "property", "system-out"}
    if more := {element.tag for element in ElementTree.fromstring(text).iter()} - own:
        yield f"elements {sorted(more)}"


def _plain(_: str) -> Iterator[str]:
    """Text in which no character does anything that `_raw` has not looked for."""
    yield from ()


LOOKS: Mapping[str, Callable[[str], Iterator[str]]] = {
    "result.json": _in_json,
    "report.html": partial(_in_page_of_ours, "report.html"),
    "index.html": partial(_in_page_of_ours, "index.html"),
    "the terminal": _plain,
    "gradebook.csv": _in_csv,
    "marks.csv": _in_csv,
    "gradescope": _in_json,
    "gradescope.csv": _in_csv,
    "canvas.csv": _in_csv,
    "moodle.csv": _in_worksheet,
    "github": _in_commands,
    "github aside": _plain,
    "classroom50": _in_json,
    "junit": _in_xml,
    "prairielearn": _in_json,
    "json": _in_json,
}
