"""A class on disk for the review desk, made up, and the desk over it as a browser or a program finds it."""

from __future__ import annotations

import http.client
import re
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from grader import __version__
from grader.course.publishing.out_files import publish, publish_class
from grader.course.record.class_settings import ClassSettings
from grader.course.record.store import Key, Store
from grader.course.record.submission_archive import pack
from grader.desk.auth import Keys
from grader.desk.classbook import Classbook
from grader.desk.serving import open_socket, server
from grader.engine import rubric
from grader.engine.chart_data import Evidence
from grader.engine.marks import marked
from grader.engine.results import CheckResult, CriterionResult, LabName, Result
from grader.labs.imu.lab import LAB
from grader.people.final_grade import NOTHING_KNOWN, HandIn
from grader.people.roster import NO_ROSTER

PNG = (
    b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR\x00\x00\x00\x01\x00\x00\x00\x01\x08\x06\x00\x00\x00\x1f\x15\xc4\x89"
    b"\x00\x00\x00\nIDATx\x9cc\x00\x01\x00\x00\x05\x00\x01\r\n-\xb4\x00\x00\x00\x00IEND\xaeB`\x82"
)
FILTER = b"class LowPassFilter:\n    def update(self, x):\n        return x  # <b>bold</b>\n"
RUBRIC = rubric.load(LAB)


@dataclass(frozen=True)
class Student:
    """One of the class: the share of each check that is kept (1 where nothing is said), and what was handed in."""

    id: str
    keeps: Mapping[str, float | None] | None = None
    says: Mapping[str, Mapping[str, Any]] | None = None
    files: Mapping[str, bytes] | None = None
    prints: tuple[int, ...] = ()
    status: str = "graded"
    name: str = ""
    notes: tuple[str, ...] = ()
    hand_in: HandIn = NOTHING_KNOWN


def result_of(student: Student) -> Result:
    """As the marker leaves it: whole, in the shipped points."""
    keeps, says = student.keeps or {}, student.says or {}

    def row(id_: str) -> CheckResult:
        share = keeps.get(id_, 1.0)
        outcome = "not_judged" if share is None else {1.0: "passed", 0.0: "failed"}.get(share, "partial")
        made = CheckResult(id_, f"Title of {id_}", outcome, share, 0.0, keeps=share)  # type: ignore[arg-type]
        return replace(made, **says.get(id_, {}))

    criteria = tuple(
        CriterionResult(c.id, c.title, c.points, tuple(row(check.id) for check in c.checks)) for c in RUBRIC.criteria
    )
    found = Result(
        student.name or student.id, student.status, criteria, notes=student.notes,  # type: ignore[arg-type]
        provenance={"submission_sha256": student.id * 3, "rubric_sha256": RUBRIC.sha256},
        lab=LabName(LAB.label, LAB.title), evidence=Evidence(fingerprint=student.prints),
    )  # fmt: skip
    return marked(replace(found, asked_sha256=RUBRIC.asked_sha256), RUBRIC)


def make_class(out: Path, students: Sequence[Student], told: Mapping[str, Sequence[str]] | None = None) -> Path:
    """OUT as `grade` leaves it."""
    settings = ClassSettings.of(RUBRIC, NO_ROSTER, "latest", LAB.truth(None, RUBRIC.settings))
    with Store(out) as store:
        store.keep_settings(settings)
        for student in students:
            key = Key(student.id, student.id * 3, RUBRIC.sha256, settings.traces_sha256, __version__)
            store.keep(key, result_of(student))
            store.keep_hand_in(student.id, student.hand_in)
            if student.files is not None:
                store.keep_files(student.id * 3, lambda files=student.files: pack(files))  # type: ignore[misc]
        store.keep_notices(told or {})
        for final_grade in publish_class(out, store, LAB).values():
            publish(out, final_grade, store, LAB)
    return out


@dataclass(frozen=True)
class Answer:
    status: int
    headers: Mapping[str, str]
    data: bytes

    @property
    def text(self) -> str:
        return self.data.decode()


class Desk:
    """The desk as a program on this machine finds it; `ask` knows the way in, `raw` nothing."""

    def __init__(self, book: Classbook, keys: Keys) -> None:
        self.book, self.keys = book, keys
        self.origin = f"http://127.0.0.1:{keys.port}"
        self._cookie = f"{keys.cookie_name}={keys.cookie}"

    def raw(self, method: str, path: str, body: bytes | None = None, **headers: str) -> Answer:
        line = http.client.HTTPConnection("127.0.0.1", self.keys.port, timeout=30)
        try:
            line.request(method, path, body, {"Host": f"127.0.0.1:{self.keys.port}", **headers})
            answer = line.getresponse()
            return Answer(answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read())
        finally:
            line.close()

    def get(self, path: str) -> Answer:
        return self.raw("GET", path, Cookie=self._cookie)

    def post(self, path: str, fields: Mapping[str, object] | Sequence[tuple[str, object]], who: str = "") -> Answer:
        cookie = self._cookie + (f"; {self.keys.cookie_name}-author={who}" if who else "")
        body = urlencode(fields).encode()
        return self.raw("POST", path, body, Cookie=cookie, Origin=self.origin)


def words(page: str) -> str:
    """What is to be read on a page, in one line."""
    return " ".join(re.sub(r"<[^>]*>", " ", page).split())


@contextmanager
def desk_over(out: Path, author: str = "prof", rubric: Path | None = None) -> Iterator[Desk]:
    """A real server on a port of its own."""
    book = Classbook(LAB, out, rubric)
    try:
        with open_socket(0) as listening:
            keys = Keys(listening.getsockname()[1])
            made = server(book, keys, author)
            thread = threading.Thread(target=made.run, kwargs={"sockets": [listening]})
            thread.start()
            try:
                yield Desk(book, keys)
            finally:
                made.should_exit = True
                thread.join()
    finally:
        book.close()
