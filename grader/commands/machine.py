"""Findings of `imugrade doctor`: isolation levels, versions, traces, packages that a class imports."""

from __future__ import annotations

import importlib.metadata
import platform
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader import __version__
from grader.base.errors import GraderError, RequestError
from grader.course.record.store import Store
from grader.course.run import missing_packages
from grader.course.run.classroom import lab_on_record
from grader.engine import rubric as rubrics
from grader.engine.lab_registry import chosen_lab
from grader.engine.recording import try_recording
from grader.platforms.classes import read_class
from grader.sandbox import visible_copies
from grader.sandbox.isolation_levels import IsolationLevel
from grader.sandbox.level_choice import probe

_NOT_ISOLATED = "no isolation: fine for your own code; `grade` needs --trust-submissions"


@dataclass(frozen=True)
class DoctorFinding:
    """Finding of `imugrade doctor` about one thing: its name, whether it is good (None: neutral), and a text to show."""

    name: str
    good: bool | None
    text: str


def examine(tell: Callable[[str], None]) -> list[tuple[str, list[DoctorFinding]]]:
    """Try out the isolation levels and the recording of hidden scenarios; return all findings about this machine by heading.

    `tell` is called with a line on what is tried next, because each trial takes some seconds.
    """
    tell("testing the isolation levels …")
    isolation = _isolation()
    tell("recording traces …")
    return [("Isolation", isolation), ("Versions", _versions()), ("Traces", [_reference()])]


def report(out: Path) -> list[str]:
    """Return lines for a bug report about the grader: versions, isolation, lab, and the grader's exceptions on record.

    Each exception kept a check from being judged. It is told with place, count and first check, but without its message, which
    could hold a name or a number of a submission. RequestError if no class was graded in the folder `out`.
    """
    with Store.existing(out) as store:
        settings, results = store.settings(), store.present().values()
    checks = [check for result in results for part in result.parts for check in part.checks if check.fault]
    first: dict[str, str] = {}
    for check in checks:
        first.setdefault(check.fault.partition(": ")[0], check.id)
    count = Counter(check.fault.partition(": ")[0] for check in checks)
    levels = ", ".join(each.isolation_level.name for each in probe() if each.usable)
    lines = [f"{finding.name}: {finding.text}" for finding in _versions()]
    lines += [f"isolation: {settings.isolation if settings else ''} (here: {levels})", f"lab: {lab_on_record(out).id}"]
    lines += [f"faults: {len(checks)} checks of {len(results)} submissions"]
    return lines + [f"{many}x {fault}; first in {first[fault]}" for fault, many in count.most_common()]


def packages_of(paths: Sequence[Path]) -> list[DoctorFinding]:
    """Return a finding on each package that submissions import and this machine lacks; if none, one that says so. No code runs."""
    lab = chosen_lab()
    missing = missing_packages.of_class(read_class(paths, lab.files).entries, rubrics.load(lab))
    lines = missing_packages.lines(missing)
    none = f"{len(missing)} submissions import no known package that is missing here"
    return [DoctorFinding("missing", False, line) for line in lines] or [DoctorFinding("missing", True, none)]


def _isolation() -> list[DoctorFinding]:
    """Return the findings about isolation: each level, the level in use, and files of the grader that student code could open."""
    tried = probe()
    best = next(each.isolation_level for each in tried if each.usable)
    rows = [
        DoctorFinding(each.isolation_level.name, each.usable, each.reason or "works here")
        for each in tried
        if each.isolation_level.isolates
    ]
    if not best.isolates:
        return [*rows, DoctorFinding("in use", False, _NOT_ISOLATED)]
    return [*rows, DoctorFinding("in use", True, best.name), _visible_copies(best)]


def _visible_copies(isolation_level: IsolationLevel) -> DoctorFinding:
    """Return whether code in the sandbox can open files of the grader, with the solution, as of a second install or a checkout."""
    try:
        search = visible_copies.search(isolation_level, chosen_lab().packages)
    except GraderError as error:
        return DoctorFinding("hidden", False, f"could not be checked from inside the sandbox: {error}")
    if search.found:
        text = f"code in the sandbox can open {len(search.found)} grader files; the first is {search.found[0]}"
    else:
        text = f"the {search.opened:,} files that code in the sandbox can open contain no grader files"
    return DoctorFinding("hidden", not search.found, text)


def _versions() -> list[DoctorFinding]:
    rows = [DoctorFinding("imugrade", None, __version__), DoctorFinding("Python", None, platform.python_version())]
    rows += [DoctorFinding(name, *_version(name)) for name in (*chosen_lab().packages, "pytest")]
    return [*rows, DoctorFinding("system", None, platform.platform())]


def _version(package: str) -> tuple[bool | None, str]:
    try:
        return None, importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return False, f"not installed; pip install {package}"


def _reference() -> DoctorFinding:
    """Return whether hidden scenarios can be recorded here, by recording them from a throw-away secret."""
    try:
        recorded = try_recording(chosen_lab())
    except (GraderError, RequestError, OSError) as problem:
        return DoctorFinding("reference", False, str(problem))
    if recorded is None:
        return DoctorFinding(
            "reference", None, "not installed: hidden traces cannot be recorded here, but those of a file work"
        )
    return DoctorFinding("reference", True, f"recorded {len(recorded.scenarios)} scenarios from a throw-away secret")
