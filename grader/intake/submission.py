"""Read one submission: find the lab's files in whatever was handed in, and keep all of them in memory."""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from grader.base import class_versions
from grader.base.errors import RequestError
from grader.base.text import printable
from grader.intake.archives import foreign, gather_archive
from grader.intake.clones import branches_note
from grader.intake.downloads import Sources, gather_sources
from grader.intake.file_budget import MAX_OPENINGS, FileBudget, Unreadable, listing
from grader.intake.folders import gather_file, gather_folder
from grader.intake.layout import MAX_LEVELS, lay_out, outwards
from grader.intake.names import ARCHIVES, FOREIGN_ARCHIVES, HOME_VERSIONS, encodable, has_suffix, is_code, safe_id
from grader.intake.placeholders import is_empty_program
from grader.intake.texts import as_programs, in_lower_case

_CONFLICT = (b"<<<<<<< ", b"=======", b">>>>>>> ")  # the lines that `git merge` leaves begin with these


@dataclass(frozen=True)
class Submission:
    """One submission as it was handed in: made by `read_submission`, and never changed by grading.

    Attributes
    ----------
    id : name of the submission's folder in the grader's output: safe, and distinct within a class
    name : the submission's original name
    files : bytes of each file by its posix path: first the files in the lab's folder by their paths from there, then those in
        `above`. Unless `status` is "ready" no code runs, and these are all files found, by their paths from the top
    notes : sentences for the report, safe to print
    status : "ready", "empty" (nothing recognisable in it) or "unreadable" (a broken archive)
    sha256 : digest of paths and bytes: the same for a folder and an archive of it, whatever the time stamps
    folder : path of the lab's folder in the handed-in folder or archive; "" if the lab's files lie at its top
    above : paths in `files` of files outside the lab's folder, and how many levels above that folder each path begins
    """

    id: str
    name: str
    files: Mapping[str, bytes]
    notes: tuple[str, ...]
    status: Literal["ready", "empty", "unreadable"]
    sha256: str
    folder: str = ""
    above: Mapping[str, int] = field(default_factory=dict)

    def origin(self, path: str) -> str:
        """Return the path from the submission's top folder, for messages, of the file that `files` holds under `path`."""
        return outwards(self.folder, self.above.get(path, 0)) + path


def original_name(path: Path) -> str:
    """Return a submission's name in reports: that of its folder or file, an archive's without suffix; ``submission`` if empty."""
    name = Path(os.path.abspath(path)).name  # "." has a name too
    suffix = next((suffix for suffix in (*ARCHIVES, *FOREIGN_ARCHIVES) if has_suffix(name, (suffix,))), "")
    return encodable(name[: len(name) - len(suffix)] if suffix and not os.path.isdir(path) else name) or "submission"


def read_submission(
    path: Path, required: Collection[str], *, id: str | None = None, name: str | None = None, sources: Sources = ()
) -> Submission:
    """Read whatever was handed in: a folder, an archive or a single file.

    Parameters
    ----------
    path : a folder, an archive (.zip, .tar.gz, .tgz, .tar), or a single program or notebook
    required : names of the files that the lab asks for
    id, name : folder name and name of the submission in the class's list (`ClassEntry`); made from the path if left out
    sources : if `path` is the download of a whole class: the files and folders in it that are this submission, each with its path
        in the submission

    Raises
    ------
    RequestError
        If there is nothing at `path`. Any content, even damaged, gives a `Submission`.
    """
    name = original_name(path) if name is None else name
    id = safe_id(name) if id is None else id
    try:
        budget = _gather(path, sources, required)
    except Unreadable as reason:
        return _nothing_to_mark(id, name, "unreadable", (str(reason),), {})
    at_home = _versions_at_home(budget)
    in_lower_case(budget, required)
    as_programs(budget, required)
    layout = lay_out(budget, required)
    if layout is None:
        status, notes = _nothing_found(budget)
        branches = branches_note(path / sources[0][0] if sources else path, required)
        return _nothing_to_mark(id, name, status, (*notes, *filter(None, [branches])), budget.files)
    if broken := _broken_notebooks(budget):
        return _nothing_to_mark(id, name, "empty", (broken, *budget.notes()), budget.files)
    levels = {**dict.fromkeys(layout.inside, 0), **layout.above}
    files = {path: budget.files[outwards(layout.folder, level) + path] for path, level in levels.items()}
    digest = _digest(("../" * levels[path] + path, content) for path, content in files.items())
    empty = sorted(path for path in layout.inside if path in required and is_empty_program(files[path]))
    unwritten = [f"{name} is empty: save it, check its size and hand it in again." for name in empty]
    notes = (*unwritten, *_merge_conflicts(files), *layout.notes, *at_home, *budget.notes())
    return Submission(id, name, files, notes, "ready", digest, layout.folder, layout.above)


def unread(id: str, name: str, why: str) -> Submission:
    """Return an unreadable submission; `why` is a sentence of the caller, such as that reading took too long."""
    return _nothing_to_mark(id, name, "unreadable", (why,), {})


def _gather(path: Path, sources: Sources, required: Collection[str]) -> FileBudget:
    """Read all files of a submission; open an archive that holds its only code. Raise RequestError if `path` is missing."""
    if not os.path.exists(path):  # Path.exists raises where a folder above may not be entered
        raise RequestError(f"{printable(str(path), 500)}: there is no such file or folder; check the path")
    budget = gather_sources(path, sources, required) if sources else _gather_outermost(path, required)
    notes: list[str] = []
    openings = 0
    while (inner := budget.lone_archive()) is not None:
        if openings == MAX_OPENINGS:
            raise Unreadable(f"{printable(inner)} is an archive in an archive in an archive; hand in the files.")
        openings += 1
        notes += [*budget.notes(), f"The submission is in {printable(inner)}, which was opened."]
        budget = gather_archive(io.BytesIO(budget.files[inner]), printable(inner), required)
    budget.remarks[:0] = notes
    return budget


def _gather_outermost(path: Path, required: Collection[str]) -> FileBudget:
    """Read the files of a folder, an archive or a single program; raise Unreadable for anything else."""
    if os.path.isdir(path):
        return gather_folder(path, required)
    name = printable(path.name)
    if not os.path.isfile(path):
        raise Unreadable(f"{name} is neither a file nor a folder; hand in a folder or a .zip of it.")
    if is_code(path.name):
        return gather_file(path)
    if has_suffix(path.name, FOREIGN_ARCHIVES) and not has_suffix(path.name, ARCHIVES):
        raise Unreadable(foreign(name))
    if has_suffix(path.name, ARCHIVES):
        try:
            with open(path, "rb") as stream:
                return gather_archive(stream, name, required)
        except OSError as error:
            raise Unreadable(f"{name} cannot be read ({error.strerror}).") from error
    raise Unreadable(f"{name} is not a folder, a .zip or a .tar.gz; hand in one of these.")


def _versions_at_home(budget: FileBudget) -> list[str]:
    """Take `check`'s record of the student's package versions out of the files; return a note if they differ from those here."""
    kept = [path for path in budget.files if tuple(path.split("/")[-2:]) == HOME_VERSIONS]
    found = [budget.files.pop(path)[:4000].decode("ascii", "replace") for path in kept]
    differing = class_versions.differences(class_versions.of_ours(found[0])) if found else []
    if not differing:
        return []
    told = ", ".join(f"{package} {there} there, {here or 'none'} here" for package, here, there in differing)
    return [
        f"`imugrade check` last ran with other versions: {told}. If code works there and not here, this may be why."
    ]


def _nothing_found(budget: FileBudget) -> tuple[Literal["empty", "unreadable"], tuple[str, ...]]:
    """Return status and notes of a submission in which no code was found: "unreadable" if a reading failed, else "empty"."""
    archives = budget.unopened()
    alone = len(budget.files) == 1 and has_suffix(next(iter(budget.files)), FOREIGN_ARCHIVES)
    if alone:
        said = [foreign(listing(archives))]
    else:
        said = [f"No .py or .ipynb file was found up to {MAX_LEVELS} folders down."]
        if deep := min((path.rpartition("/")[0] for path in filter(is_code, budget.files)), default=""):
            said.append(f"There is code further down, in {printable(deep)}; hand in that folder itself.")
        if archives:
            said.append(f"Not opened, because an archive must be alone in its folder: {listing(archives)}.")
    return ("unreadable" if budget.broken or alone else "empty"), (*said, *budget.notes())


def _broken_notebooks(budget: FileBudget) -> str:
    """Return a note for a submission whose only code is notebooks that cannot be opened; "" if there is other code."""
    code = sorted(filter(is_code, budget.files))
    if not all(path.endswith(".ipynb") and not _is_notebook(budget.files[path]) for path in code):
        return ""
    if conflicts := _merge_conflicts({path: budget.files[path] for path in code}):
        return f"No program could be read: {conflicts[0]}"
    return f"No program could be read: {listing(code)} is no notebook, or was cut off on the way; hand it in again."


def _merge_conflicts(files: Mapping[str, bytes]) -> list[str]:
    """Return a note for each file of code with the markers that `git merge` leaves, with the line of the first one."""
    notes = []
    for path in sorted(filter(is_code, files)):
        lines = [line.lstrip(b' \t"') for line in files[path].splitlines()]  # a notebook's lines are strings in JSON
        at = [next((n for n, line in enumerate(lines, 1) if line.startswith(mark)), 0) for mark in _CONFLICT]
        if 0 < at[0] < at[1] < at[2]:
            where = f"{printable(path)} has an unresolved merge conflict in line {at[0]}"
            notes.append(f"{where}; resolve it and hand it in again.")
    return notes


def _is_notebook(content: bytes) -> bool:
    try:
        return isinstance(json.loads(content), dict)
    except (ValueError, RecursionError):
        return False


def _nothing_to_mark(
    id: str, name: str, status: Literal["empty", "unreadable"], notes: tuple[str, ...], files: Mapping[str, bytes]
) -> Submission:
    """Return a submission without gradable files; a person can still see its files, and the notes are part of its digest."""
    digest = _digest([*((note, status.encode()) for note in notes), *files.items()])
    return Submission(id, name, files, notes, status, digest)


def _digest(items: Iterable[tuple[str, bytes]]) -> str:
    """Return the SHA-256 of sorted paths and bytes, each with its length, so that no two sets of files have one digest."""
    digest = hashlib.sha256()
    for path, data in sorted(items):
        for part in (path.encode(), data):
            digest.update(b"%d:" % len(part) + part)
    return digest.hexdigest()
