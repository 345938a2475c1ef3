"""Find the submissions of a class, in folders, archives and downloads of platforms, without reading them."""

from __future__ import annotations

import os
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.intake.downloads import Download, Sources, open_download
from grader.intake.file_budget import LINK, REFUSED
from grader.intake.folders import entries_of, is_link, status_of
from grader.intake.layout import MAX_LEVELS
from grader.intake.names import (
    ARCHIVES,
    CODE,
    FOREIGN_ARCHIVES,
    distinct_ids,
    encodable,
    folded,
    has_suffix,
    is_code,
    is_litter,
)
from grader.intake.submission import Submission, original_name, read_submission
from grader.people.final_grade import NOTHING_KNOWN, HandIn
from grader.platforms import registry
from grader.platforms.found import Found, Shape

UNPLACED = "not a folder, a .zip or a .tar.gz, so whose it is cannot be told"
SUPERSEDED = "an earlier attempt; the latest one is graded"
MAX_LOOKED_AT = 50_000  # largest number of entries searched to tell a class from a submission

ATTEMPTS = ("latest", "best")


@dataclass(frozen=True)
class ClassEntry:
    """Path and name of one submission of a class, small enough to send to the process that reads and grades it.

    Several attempts of the same student or group share an id. `sources` (paths in `path`, each with its name in the submission) is
    empty where all of `path` is the submission; `required` are the names of the files that the lab asks for.
    """

    id: str
    name: str
    path: Path
    required: tuple[str, ...]
    sources: Sources = ()
    hand_in: HandIn = NOTHING_KNOWN

    def read(self) -> Submission:
        """Read the submission's files; raise RequestError if the submission no longer exists."""
        return read_submission(self.path, self.required, id=self.id, name=self.name, sources=self.sources)


@dataclass(frozen=True)
class Intake:
    """Submissions of a class. `leftovers`: what is not graded and why; `notices`: each download's kind and submission count."""

    entries: tuple[ClassEntry, ...]
    leftovers: tuple[str, ...]
    notices: tuple[str, ...] = ()


def _read_folders(download: Download) -> Shape:
    """Take every folder and archive at the top of a zip as a submission, for `--from folders`; other files are left over."""
    fits = {
        name: is_folder or has_suffix(name, (*ARCHIVES, *FOREIGN_ARCHIVES)) for name, is_folder in download.top.items()
    }
    found = tuple(
        Found(f"folder:{name}", called, called, download.path, _all_of(download, name))
        for name, called in ((n, encodable(n) if download.top[n] else original_name(Path(n))) for n in fits if fits[n])
    )
    return Shape("folders of submissions", found, tuple((name, UNPLACED) for name, fit in fits.items() if not fit))


def _all_of(download: Download, name: str) -> Sources:
    return ((download.place(name), "" if download.top[name] else encodable(name)),)


def read_class(
    paths: Sequence[Path],
    required: tuple[str, ...],
    shape: str | None = None,
    attempts: str = "latest",
    known: Mapping[str, str] = MappingProxyType({}),
) -> Intake:
    """Find the submissions of a class, without reading their files, and return where they lie and what else lies there.

    Parameters
    ----------
    paths
        Each a folder of submissions (folders and archives), a platform's download (a folder or a zip), one submission, or an
        archive of one.
    required
        Names of the files that the lab asks for.
    shape
        The name of a platform that reads downloads, or "folders"; None recognises what each path is.
    attempts
        "latest" keeps the last attempt of the same people; "best" keeps all attempts, to choose the best once they are graded.
    known
        Students' names by the platform's user number, from the roster, to resolve ambiguous file names.

    Raises
    ------
    RequestError
        If there is nothing at a path, its folder cannot be listed, or it is not what `shape` says.
    """
    found: dict[str, Found] = {}  # by real path and place: a submission that is named twice is graded once
    leftovers: list[str] = []
    notices: list[str] = []
    for path in paths:
        whole = _shape_at(path, shape, known)
        if whole is None:
            for place, objection in _found_at(path, required):
                if objection:
                    leftovers.append(f"{printable(str(place), 500)}: {objection}")
                else:
                    found.setdefault(os.path.realpath(place), _whole(place))
            continue
        notices.append(f"{printable(str(path), 500)}: {whole.title}, {_counted(whole)}")
        leftovers += [f"{printable(str(path / name), 500)}: {why}" for name, why in whole.left]
        for each in whole.found:
            found.setdefault(f"{os.path.realpath(path)}\0{each.sources}", each)
    chosen, earlier = _attempts(found.values(), attempts)
    return Intake(_with_ids(chosen, required), tuple(sorted(leftovers + earlier)), tuple(notices))


def _counted(shape: Shape) -> str:
    return f"{len(shape.found)} submission{'s' * (len(shape.found) != 1)}"


def _shape_at(path: Path, wanted: str | None, known: Mapping[str, str]) -> Shape | None:
    """Return the contents of a platform's download; None for a plain folder, one submission or an archive of one.

    Raise RequestError if there is nothing at the path, or it is no download of the platform `wanted`.
    """
    if not os.path.exists(path):
        raise RequestError(f"{printable(str(path), 500)}: there is no such file or folder; check the path")
    if wanted == registry.FOLDERS:
        tops = [] if os.path.isdir(path) else open_download(path)
        return next((_read_folders(top) for top in reversed(tops)), None)
    for top in open_download(path) if os.path.isdir(path) or has_suffix(path.name, (".zip",)) else ():
        for platform in registry.platforms("read"):
            shape = (
                platform.read(replace(top, known=known)) if platform.read and wanted in (None, platform.name) else None
            )
            if shape is not None and shape.found:
                return replace(shape, left=(*shape.left, *top.left))
    if wanted is not None:
        raise RequestError(f"--from {wanted}: {printable(str(path), 500)} does not have that shape; leave --from out")
    return None


def _whole(place: Path) -> Found:
    name = original_name(place)
    return Found(os.path.realpath(place), name, name, place)


def _attempts(found: Iterable[Found], attempts: str) -> tuple[list[Found], list[str]]:
    """Return the attempts to grade, earlier ones of a student or group first, and messages about those that are superseded."""
    people: defaultdict[str, list[Found]] = defaultdict(list)
    for each in found:
        people[each.student].append(each)
    chosen: list[Found] = []
    earlier: list[str] = []
    for own in people.values():
        in_order = sorted(own, key=lambda each: each.order)
        chosen += in_order if attempts == "best" else in_order[-1:]
        earlier += [f"{_named_by_place(each)}: {SUPERSEDED}" for each in in_order[:-1] if attempts == "latest"]
    return chosen, earlier


def _named_by_place(found: Found) -> str:
    """Return the path of a submission for messages; for several loose files, the path of each."""
    first, *others = [place for place, _ in found.sources] or [""]
    return ", ".join((printable(str(found.path / first), 500), *(printable(place, 200) for place in others)))


def _with_ids(found: list[Found], required: tuple[str, ...]) -> tuple[ClassEntry, ...]:
    """Give submissions an id for each student, and a name: without an archive's suffix, unless two names would then be equal."""
    shared = Counter(each.name for each in found if not each.sources)
    named = {each: _name(each, shared) for each in found}
    students = {each.student: named[each] if not each.sources else each.id_source for each in found}
    order = sorted(students, key=lambda student: (students[student], student))
    ids = dict(zip(order, distinct_ids(students[student] for student in order), strict=True))
    place = {student: number for number, student in enumerate(order)}
    ranked = sorted(found, key=lambda each: place[each.student])  # stable: attempts stay in order
    return tuple(
        ClassEntry(ids[each.student], named[each], each.path, required, each.sources, each.hand_in) for each in ranked
    )


def _name(found: Found, shared: Counter[str]) -> str:
    if found.sources or shared[found.name] == 1 or os.path.isdir(found.path):
        return found.name
    return encodable(found.path.name)


def _found_at(path: Path, required: Collection[str]) -> Iterator[tuple[Path, str]]:
    """Yield the submissions at a path, each with "", and the files that are no submission, each with the reason."""
    if not os.path.isdir(path):
        yield path, "" if has_suffix(path.name, (*ARCHIVES, *FOREIGN_ARCHIVES, *CODE)) else UNPLACED
        return
    if _is_submission(path, required):
        yield path, ""
        return
    for entry in entries_of(path):
        place = path / entry.name
        if not _is_ignored(entry):
            yield place, _objection(entry)


def _is_ignored(entry: os.DirEntry[str]) -> bool:
    """Return whether an entry of a class folder is hidden, left behind by a tool, or the output folder of an earlier run."""
    return entry.name.startswith(".") or is_litter((entry.name,)) or _is_graded(Path(entry.path))


def _is_graded(folder: Path) -> bool:
    """Return whether a folder is the output (OUT) of an earlier run: it has a results file and no program of a student."""
    return os.path.isfile(folder / "results.sqlite") and not _holds_file(folder, is_code)


def _objection(entry: os.DirEntry[str]) -> str:
    """Return why this entry of a class folder is no submission, for messages; "" if it is one."""
    status = status_of(entry)
    if status is None or is_link(status):
        return REFUSED if status is None else LINK
    if entry.is_dir() or (entry.is_file() and has_suffix(entry.name, (*ARCHIVES, *FOREIGN_ARCHIVES))):
        return ""  # an archive of an unsupported kind is a submission, too
    return UNPLACED


def _is_submission(folder: Path, required: Collection[str]) -> bool:
    """Return whether a folder is one submission, not a class: it holds a required file, or code and no submissions."""
    entries = [entry for entry in entries_of(folder) if not _is_ignored(entry)]
    names = [entry.name for entry in entries if entry.is_file(follow_symlinks=False)]
    asked = set(map(folded, required))
    if any(folded(name) in asked for name in names):
        return True
    if not any(is_code(name) for name in names):
        return False
    return not any(has_suffix(name, ARCHIVES) for name in names) and not _holds_file(
        folder, lambda name: folded(name) in asked
    )


def _holds_file(folder: Path, wanted: Callable[[str], bool]) -> bool:
    """Return whether a file with a name that is `wanted` lies in this folder or up to `MAX_LEVELS` below.

    After `MAX_LOOKED_AT` entries the search goes no deeper, so that a huge folder costs no minutes.
    """
    looked_at = 0
    for here, folders, names in os.walk(folder):
        level = len(Path(here).relative_to(folder).parts)
        looked_at += len(folders) + len(names)
        if any(map(wanted, names)):
            return True
        if level >= MAX_LEVELS or looked_at > MAX_LOOKED_AT:
            folders.clear()
        folders[:] = [name for name in folders if not is_litter((name,))]
    return False
