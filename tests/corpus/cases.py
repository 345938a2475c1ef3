"""Loader of the corpus: each YAML file beside this one is a table of submissions, each row a base, an edit, what it loses, why.

A table has groups, a group has rows, and a row has a name and these keys.

How the submission is made, in this order:

base
    A base of `bases.yaml`, another row of the table, or ``TABLE/ROW``. A row without one is its `files` alone.
read, collect, plot, ... (a key of `pieces.PARTS`)
    The part that takes the place of the base's: its code, or the name of the base that has it.
imu_reader.py, ... (a key with a dot)
    The patch of a file, see `patched`.
append
    Text for the end of a file.
encode
    The encoding of a file.
through
    A function of `special` that changes every file.
folder, move
    The folder that all files so far are put into; new names of some.
without
    Files that are taken away.
files
    More files: text, or one of ``{notebook: [cells], lines: false}``, ``{bytes: text}``, ``{link: target}``,
    ``{made: a key of special.MADE}``, ``{row: TABLE/ROW}``. A cell is code, ``{markdown: text}``, or ``{base: part}``.
as
    How it is handed in, see `writing.write`.

Every other key is a field of `Case`. Checks of the table's own criterion are named without it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from grader.labs.imu.lab import LAB
from tests.corpus import special
from tests.corpus.pieces import BASES, PARTS, lab_of, part, read
from tests.corpus.writing import Content, Files, Late, Link, notebook

CRITERIA = tuple(part.id for part in LAB.parts)
EXTENSIONS = {part.id: part.home for part in LAB.bonuses}
"""The file of each extension."""
ORIGINS = {
    "habit": "follows a habit of public code; what it loses was decided before the code that judges it was mended",
    "marker": "marked by hand before anything judged it; no list of faults led the pen",
    "newcomer": "written after the checks, against the contract and the list of faults alone",
    "outside": "a marker from outside handed it in, and wanted the points that its row says",
}
"""What `origin` means."""
_ORIGIN_OF = {"habits": "habit", "unforeseen": "marker", "unforeseen sound": "marker"}
"""The origin of all cases of a part."""
_TABLES = (
    "sound_people", "sound_styles", "sound_plots", "sound_layouts", "sound_habits", "sound_newcomers", "sensor_access", "data_collection",
    "visualization", "noise_model", "filtering", "whole_files", "pairs", "broken", "module_level", "extensions", "repairable", "replays",
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A submission, and what a fair marker says to it.

    Attributes
    ----------
    part : str
        The group of the corpus: sound, faulty, lookalikes, pairs, broken, module level, nothing, extensions, habits,
        unforeseen, repairable, replays.
    name : str
        Unique in its part.
    files : Files
        The submission. In the part "module level": the sheet's steps, see `pieces.LAYOUTS`.
    as_ : str
        How it is handed in, see `writing.write`.
    only : str or None
        The only part of the lab that is judged.
    criterion : str
        The criterion or the extension that the case is about, and the only one that may lose points; "" if none may.
    fault : str
        The id in `faults.yaml` of the fault; "" where it has no name.
    faults : mapping of str to str
        Of two faults: the id of each and the criterion that it costs.
    also : tuple of str
        Other ids that are a true description of the same fault.
    never : tuple of str
        Ids that describe another fault that looks like this one; naming them would be wrong.
    names : tuple of str
        Ids that may be named; of a broken submission the first should be named, or another one in its place.
    loses : tuple of str
        The only checks that may be lost; empty where every check of the criterion may.
    elsewhere : tuple of str
        Criteria that need the same missing part, and may lose points too.
    most : float
        The most points that the lost checks cost together.
    takes : mapping of str to float
        The most points that a fair marker takes, by check or by criterion; none elsewhere.
    must : tuple of str
        Criteria that have to lose something.
    earns : float
        The most points that the criterion still gets, for form.
    status : tuple of str
        The statuses of the result that are right.
    keeps : tuple of str
        Criteria that stay at full points.
    costs : str
        The criterion that has to lose points; "" if none has to.
    file : str
        The file that does not run.
    origin : str
        Where the case comes from, a key of `ORIGINS`; "" for one that was written with the checks.
    why : str
        Why a fair marker says so, or what is special about the case.
    """

    part: str
    name: str
    files: Files
    as_: str = "folder"
    only: str | None = None
    criterion: str = ""
    fault: str = ""
    faults: Mapping[str, str] | None = None
    also: tuple[str, ...] = ()
    never: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    loses: tuple[str, ...] = ()
    elsewhere: tuple[str, ...] = ()
    most: float = 0.0
    takes: Mapping[str, float] | None = None
    must: tuple[str, ...] = ()
    earns: float = 0.0
    status: tuple[str, ...] = ("graded",)
    keeps: tuple[str, ...] = ()
    costs: str = ""
    file: str = ""
    origin: str = ""
    why: str = ""

    @property
    def id(self) -> str:
        return f"{self.part}/{self.name}"

    @property
    def text(self) -> str:
        """The text of the file that does not run."""
        return str(self.files[self.file])


_LISTS = ("also", "never", "names", "loses", "elsewhere", "must", "status", "keeps")
_PLAIN = ("criterion", "fault", "most", "earns", "costs", "file", "origin", "why")
_MAKING = ("base", *PARTS, "append", "encode", "through", "folder", "move", "without", "files")
_KEYS = {*_LISTS, *_PLAIN, *_MAKING, "as", "faults", "takes"}

Row = Mapping[str, Any]


@cache
def of(part: str) -> tuple[Case, ...]:
    """Return the cases of a part, table by table."""
    return tuple(case for name in _TABLES for case in table(name) if case.part == part)


def case(part: str, name: str) -> Case:
    """Return one case, or raise a KeyError."""
    return {case.name: case for case in of(part)}[name]


@cache
def table(name: str) -> tuple[Case, ...]:
    """Return the cases of a table, in its order."""
    return tuple(
        _case(name, part, row_name, row) for part, rows in read(name).items() for row_name, row in rows.items()
    )


def _case(table_name: str, part: str, name: str, row: Row) -> Case:
    if unknown := {key for key in row if "." not in key} - _KEYS:
        raise ValueError(f"{table_name}.yaml: {name}: unknown keys {sorted(unknown)}")
    criterion = row.get("criterion", table_name if table_name in CRITERIA else "")
    fields: dict[str, Any] = {key: row[key] for key in _PLAIN if key in row}
    fields |= {key: _names(row[key], criterion if key == "loses" else "") for key in _LISTS if key in row}
    if "takes" in row:
        ids = _names(list(row["takes"]), criterion)
        fields["takes"] = dict(zip(ids, row["takes"].values(), strict=True))
    if "faults" in row:
        fields["faults"] = row["faults"]
    fields["criterion"] = criterion
    fields["only"] = criterion if part == "extensions" else None
    fields.setdefault("origin", _ORIGIN_OF.get(part, ""))
    fields["as_"] = row.get("as", "folder")
    return Case(part, name, _files(table_name, row), **fields)


def _names(value: str | list[str], criterion: str) -> tuple[str, ...]:
    """``all but filtering`` of the criteria, one name, or several; a check without its criterion is one of `criterion`."""
    if isinstance(value, str) and value.startswith("all"):
        return tuple(name for name in CRITERIA if name not in value.split())
    names = [value] if isinstance(value, str) else value
    return tuple(f"{criterion}.{name}" if criterion and "." not in name else name for name in names)


# ---------------------------------------------------------------- files


def _files(table_name: str, row: Row) -> Files:
    files = _base(table_name, row)
    for path, patch in row.items():
        if "." in path:
            files[path] = patched(_text(files[path]), patch)
    for path, text in row.get("append", {}).items():
        files[path] = _text(files[path]) + text
    for path, encoding in row.get("encode", {}).items():
        files[path] = _text(files[path]).encode(encoding)
    if "through" in row:
        change: Callable[[str], str] = getattr(special, row["through"])
        files = {path: change(_text(text)) for path, text in files.items()}
    moved = row.get("move", {})
    folder = f"{row['folder']}/" if "folder" in row else ""
    files = {folder + moved.get(path, path): content for path, content in files.items()}
    for path in row.get("without", ()):
        del files[path]
    more = {path: _content(path, content) for path, content in row.get("files", {}).items()}
    if any(callable(content) for content in more.values()):
        return Late({**files, **more})
    return {**files, **more}  # type: ignore[dict-item] # none is made late


def _base(table_name: str, row: Row) -> dict[str, Content]:
    base = row.get("base", "")
    if not base:
        return {}
    if base in BASES:
        return dict(lab_of(base, {key: code for key, code in row.items() if key in PARTS}))
    return dict(_files(*_row(base if "/" in base else f"{table_name}/{base}")))


def _row(path: str) -> tuple[str, Row]:
    """The table and the row of ``TABLE/ROW``."""
    table_name, _, name = path.partition("/")
    for rows in read(table_name).values():
        if name in rows:
            return table_name, rows[name]
    raise ValueError(f"{table_name}.yaml has no row {name!r}")


def _text(content: Content) -> str:
    if not isinstance(content, str):
        raise TypeError(f"only text can be edited, not {content!r}")
    return content


def _content(path: str, content: str | Row) -> Content | Callable[[], Content]:
    if isinstance(content, str):
        return content
    if "notebook" in content:
        return notebook(*map(_cell, content["notebook"]), lines=content.get("lines", True))
    if "bytes" in content:
        return str(content["bytes"]).encode("latin-1")
    if "link" in content:
        return Link(content["link"])
    if "row" in content:
        return _files(*_row(content["row"]))[path]
    return special.MADE[content["made"]]


def _cell(cell: str | Mapping[str, str]) -> str | tuple[str, str]:
    if isinstance(cell, str):
        return cell
    ((kind, value),) = cell.items()
    return part(kind, value) if kind in BASES else (kind, value)


def every() -> Iterator[Case]:
    """Return the cases of all tables."""
    for name in _TABLES:
        yield from table(name)


# ---------------------------------------------------------------- patches


def patched(text: str, patch: str) -> str:
    """Return a text with each hunk of a patch applied.

    A line that begins with ``-`` is taken away, one with ``+`` is added, one with a space (and an empty one) stays where it is;
    ``@@`` separates hunks.

    Raises
    ------
    ValueError
        If the lines that a hunk expects are not there exactly once: the case would then not be what its row says.
    """
    lines = text.split("\n")
    for hunk in filter(None, re.split(r"^@@\n", patch, flags=re.MULTILINE)):
        changes = hunk.removesuffix("\n").split("\n")
        if wrong := [line for line in changes if line[:1] not in ("", " ", "-", "+")]:
            raise ValueError(f"a line of a patch begins with a space, -, + or is @@: {wrong[0]!r}")
        old = [line[1:] for line in changes if line[:1] != "+"]
        found = [i for i in range(len(lines) - len(old) + 1) if lines[i] == old[0] and lines[i : i + len(old)] == old]
        if len(found) != 1:
            raise ValueError(f"the lines {old} are there {len(found)} times, once is needed")
        lines[found[0] : found[0] + len(old)] = [line[1:] for line in changes if line[:1] != "-"]
    return "\n".join(lines)
