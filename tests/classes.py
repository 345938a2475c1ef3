"""One class as a download of each platform, and a reader of each platform's upload."""

from __future__ import annotations

import csv
import io
import re
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import yaml

from tests.corpus.pieces import FILTER_INCREMENT, tidy
from tests.corpus.writing import Files, as_bytes, write, zipped

_ODD = (
    ("Jürgen", "Müßig"),
    ("Anna \"Ann\"", "Lee"),
    ("=SUM(A1)", "Formula"),
    ("Wei", "Li, Jr."),
    ("Sean", "O'Brien-Smith"),
    ("李", "雷"),
    ("Zoë", "van der Berg"),
)  # fmt: skip
ASSIGNMENT = "Lab 04-01 (4711)"


@dataclass(frozen=True)
class Student:
    """One of the class; `number` tells them apart everywhere."""

    number: int
    first: str
    last: str
    files: Files

    @property
    def name(self) -> str:
        return f"{self.first} {self.last}"

    @property
    def canvas(self) -> str:
        return str(10_000 + self.number)

    @property
    def moodle(self) -> str:
        return str(500 + self.number)

    @property
    def sid(self) -> str:
        return f"s{self.number:05}"

    @property
    def login(self) -> str:
        return f"user{self.number:04}"

    @property
    def email(self) -> str:
        return f"{self.login}@example.edu"


def filters_alone(wrong: float) -> Files:
    """Marked fast, and each with bytes of its own."""
    return {
        "filters.py": "import numpy as np\n\n\n"
        + FILTER_INCREMENT.replace("self.alpha * (x", f"{wrong} * self.alpha * (x")
    }


def a_class(count: int, kinds: Sequence[Files] | None = None) -> list[Student]:
    """Students with odd names, every one with a different one, and files by turns."""
    kinds = kinds or (tidy(), filters_alone(1.0), filters_alone(0.5))
    names = [(f"{first}{'' if turn == 0 else turn}", last) for turn in range(count) for first, last in _ODD]
    return [Student(i, *names[i], kinds[i % len(kinds)]) for i in range(count)]


# ---- in ----


def folders(students: Sequence[Student], root: Path) -> Path:
    """A folder each, every third an archive."""
    for student in students:
        write(student.files, root / student.login, "zip" if student.number % 3 == 2 else "folder")
    return root


def canvas(students: Sequence[Student], root: Path) -> Path:
    """Loose files; some zipped by the student, some late, some handed in again."""
    members: dict[str, bytes] = {}
    for student in students:
        late = "LATE_" if student.number % 4 == 3 else ""
        sortable = re.sub(r"[^\w]", "", f"{student.last}, {student.first}".lower())
        files = {"lab.zip": zipped(student.files)} if student.number % 3 == 2 else student.files
        for at, (name, content) in enumerate(_contents(files)):
            again = re.sub(r"(\.\w+)$", r"-1\1", name) if student.number % 5 == 4 else name
            flat = re.sub(r'[\x00/\\:*?"<>|]+', "_", again)
            number = 90_000 + 100 * student.number + at
            members[f"{sortable}_{late}{student.canvas}_{number}_{flat}"] = content
    return write(members, root / "robotics-lab-04-01_submissions", "zip")


def moodle(students: Sequence[Student], root: Path) -> Path:
    """Folder mode."""
    return write(dict(_moodle(students, "assignsubmission_file/")), root / "ROB-Lab 04-01-77", "zip")


def moodle_flat(students: Sequence[Student], root: Path) -> Path:
    return write(dict(_moodle(students, "assignsubmission_file_")), root / "ROB-Lab 04-01-77", "zip")


def moodle_unzipped(students: Sequence[Student], root: Path) -> Path:
    """As Moodle before 4.1 named folders, unpacked by the teacher."""
    return write(dict(_moodle(students, "assignsubmission_file_/")), root)


def _moodle(students: Sequence[Student], middle: str) -> Iterator[tuple[str, bytes]]:
    for student in students:
        for name, content in _contents(student.files):
            yield f"{student.name.replace('_', ' ')}_{student.moodle}_{middle}{name}", content


def gradescope(students: Sequence[Student], root: Path) -> Path:
    """The export; keys keep the colon of Ruby's symbols."""
    members: dict[str, bytes] = {}
    metadata: dict[str, object] = {}
    for student in students:
        folder = f"submission_{770_000 + student.number}"
        metadata[folder] = {
            ":submitters": [{":name": student.name, ":sid": student.sid, ":email": student.email}],
            ":created_at": datetime.fromisoformat("2026-11-20T13:00:00.123456-08:00"),
            ":score": 0.0,
            ":status": "processed",
            ":results": {"tests": []},
        }
        for name, content in _contents(student.files):
            members[f"assignment_99_export/{folder}/{name}"] = content
    members["assignment_99_export/submission_metadata.yml"] = yaml.safe_dump(metadata, allow_unicode=True).encode()
    return write(members, root / "assignment_99_export", "zip")


def classroom50(students: Sequence[Student], root: Path) -> Path:
    """`gh teacher download`: clones, and a `scores.csv` beside them."""
    write({}, root)
    with open(root / "scores.csv", "w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream)
        names = ("username", "first_name", "last_name", "email", "section", "score", "max_score", "datetime")
        table.writerow([*names, "submission_tag"])
        for s in students:
            when = "2026-11-20T21:00:00Z"
            table.writerow([s.login, s.first, s.last, s.email, "B", "", "", when, "submit/x"])
            _clone(root / f"rob-lab4-{s.login}", {**s.files, "result.json": "{}"})
    return root


def git(students: Sequence[Student], root: Path) -> Path:
    for student in students:
        _clone(root / f"lab4-{student.login}", student.files)
    return root


SHAPES: dict[str, Callable[[Sequence[Student], Path], Path]] = {
    shape.__name__: shape
    for shape in (folders, canvas, moodle, moodle_flat, moodle_unzipped, gradescope, classroom50, git)
}


def _contents(files: Files) -> Iterator[tuple[str, bytes]]:
    for name, content in files.items():
        assert isinstance(content, (str, bytes))
        yield name, as_bytes(content)


def _clone(folder: Path, files: Files) -> None:
    git = {".git/HEAD": "ref: refs/heads/main\n", ".git/config": "[core]\n\tfsmonitor = touch /tmp/never\n"}
    write({**files, **git}, folder)


# ---- what the instructor exports from the platform ----


def canvas_gradebook(students: Sequence[Student]) -> bytes:
    """As `gradebook_exporter.rb` writes it: the points in the second line, read-only totals at the end."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    info = ["Student", "ID", "SIS User ID", "SIS Login ID", "Section"]
    table.writerow([*info, "Lab 03 (4700)", ASSIGNMENT, "Current Score", "Final Score"])
    table.writerow(["    Points Possible", "", "", "", "", "100.0", "100.0", "(read only)", "(read only)"])
    for s in students:
        table.writerow([f"{s.last}, {s.first}", s.canvas, s.sid, s.login, "Tue, 10:00", "55.0", "", "55.0", "27.5"])
    table.writerow(["Student, Test", "99999", "", "abcdef", "Tue, 10:00", "", "", "", ""])
    return text.getvalue().encode()


def moodle_worksheet(students: Sequence[Student]) -> bytes:
    """As Moodle writes it: a byte order mark, some cells in quotes that need none, CRLF."""
    head = (
        'Identifier,"Full name","Email address",Status,Grade,"Maximum grade","Grade can be changed",'
        '"Last modified (submission)","Last modified (grade)","Feedback comments"'
    )
    lines = [head]
    for s in students:
        name = s.name.replace('"', '""')
        facts = '"Submitted for grading",,100.00,Yes,"Friday, 20 November 2026, 9:00 PM",-,'
        lines.append(f'"Participant {s.moodle}","{name}",{s.email},{facts}')
    lines.append('"Participant 9999","Never There",never@example.edu,"No submission",,100.00,Yes,-,-,')
    return b"\xef\xbb\xbf" + "".join(f"{line}\r\n" for line in lines).encode()


# ---- what the platform makes of an upload ----


def canvas_import(data: bytes) -> dict[str, float | None]:
    """Scores of the one assignment by Canvas id; None where there is none."""
    rows = list(csv.reader(io.StringIO(data.decode(), newline="")))
    head = rows[0]
    assignments = [i for i, title in enumerate(head) if re.fullmatch(r"(.*)\s\((\d+)\)", title)]
    assert [head[i] for i in assignments] == [ASSIGNMENT]
    scores = {row[1]: row[assignments[0]] for row in rows[2:]}
    return {id_: None if cell in ("", "-") else round(float(cell), 2) for id_, cell in scores.items()}


def moodle_import(before: bytes, data: bytes) -> dict[str, float]:
    """Grades by participant number that Moodle takes from a worksheet, and proof that nothing else in it changed."""
    own = {"Grade", "Feedback comments"}
    old, new = (list(csv.DictReader(io.StringIO(text.decode("utf-8-sig"), newline=""))) for text in (before, data))
    assert [{k: v for k, v in row.items() if k not in own} for row in old] == [
        {k: v for k, v in row.items() if k not in own} for row in new
    ]
    grades: dict[str, float] = {}
    for row in new:
        assert {"Identifier", "Grade", "Last modified (grade)"} <= set(row)
        number, grade = row["Identifier"].removeprefix("Participant "), row["Grade"].strip()
        if grade and row["Grade can be changed"] == "Yes" and 0 <= float(grade) <= float(row["Maximum grade"]):
            grades[number] = float(grade)
    return grades


def moodle_feedback(data: bytes) -> dict[str, bytes]:
    """Files by participant number that Moodle takes from a zip of feedback."""
    taken: dict[str, bytes] = {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for name in archive.namelist():
            for part in name.split("/"):
                words = part.split("_", 4)
                kind = "_".join(words[2:4])
                if kind in ("assignsubmission_file", "assignfeedback_file") and words[1].isdigit():
                    assert words[1] not in taken
                    taken[words[1]] = archive.read(name)
    return taken


def canvas_feedback(data: bytes) -> dict[tuple[str, str], bytes]:
    """Files by user and attachment that Canvas takes: the first two tokens that are numbers."""
    taken: dict[tuple[str, str], bytes] = {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for name in archive.namelist():
            numbers = [token for token in name.rpartition("/")[2].split("_") if token.isdigit()]
            if len(numbers) >= 2:
                taken[(numbers[0], numbers[1])] = archive.read(name)
    return taken


def marks_from(
    shape: str, students: Sequence[Student], out: Path, run: Callable[..., tuple[int, str, str]]
) -> dict[str, float | None]:
    """Export a graded class to its own platform with `imugrade` and import it there: final points by student number."""
    made = out / "upload.csv"

    def export(name: str, *more: object) -> bytes:
        assert run("export", out, "--format", name, *more, "-o", made)[0] == 0
        return made.read_bytes()

    if shape == "canvas":
        (out / "gradebook-export.csv").write_bytes(canvas_gradebook(students))
        scores = canvas_import(export("canvas", "--template", out / "gradebook-export.csv", "--column", "4711"))
        return {s.sid: scores[s.canvas] for s in students}
    if shape.startswith("moodle"):
        before = moodle_worksheet(students)
        (out / "worksheet.csv").write_bytes(before)
        grades = moodle_import(before, export("moodle", "--template", out / "worksheet.csv"))
        return {s.sid: grades.get(s.moodle) for s in students}
    name = "gradescope" if shape == "gradescope" else "csv"
    rows = list(csv.DictReader(io.StringIO(export(name).decode("utf-8-sig"))))
    if shape == "gradescope":
        points = {row["SID"]: row["Total Score"] for row in rows}
        return {s.sid: float(points[s.sid]) for s in students}
    totals = {row["submission"].rpartition("-")[2]: row["total"] for row in rows}
    return {s.sid: float(totals[s.login]) for s in students}
