"""The isolation levels, best first, one record each. What differs between levels is a field of the record; no name is compared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class IsolationLevel:
    """One isolation level, a way to keep student code from the machine: what it consists of, and how it is set up.

    Attributes
    ----------
    name
        Its name in `provenance.isolation` of a result, in `imugrade doctor` and as a value of `--isolation`.
    around, needs
        Texts: what surrounds a worker, and what a machine must allow for this level.
    isolates
        Whether it isolates student code at all.
    own_root
        Whether the sandbox has its own root file system, without the paths of the host.
    own_namespaces
        Whether each worker has namespaces and a disk of its own, which the zygote (the parent process of all workers) creates.
    program
        Name of an installed program that isolates the zygote; "" if the zygote isolates itself.
    """

    name: str
    around: str
    needs: str
    isolates: bool = True
    own_root: bool = False
    own_namespaces: bool = False
    program: str = ""


@dataclass(frozen=True)
class Promise:
    """A guarantee to users that SECURITY.md lists: its `words`, and `kept_on`, which tells whether an isolation level gives it."""

    words: str
    kept_on: Callable[[IsolationLevel], bool]


LEVELS = (
    IsolationLevel(
        "full",
        "user, mount, pid, ipc, uts and network namespaces; a read-only root with what a sandbox shows (below) and nothing else; "
        "its own 64 MB of disk in memory; limits; no capabilities; Landlock; a seccomp allowlist",
        "user namespaces",
        own_root=True,
        own_namespaces=True,
    ),
    IsolationLevel(
        "bubblewrap",
        "the workers' parent process in `bwrap`; around each worker limits, Landlock and the allowlist",
        "the program `bwrap`",
        own_root=True,
        program="bwrap",
    ),
    IsolationLevel("landlock", "limits, Landlock and the allowlist, without any privilege", "Linux 5.13"),
    IsolationLevel("none", "a fresh process with limits of time and memory", "nothing", isolates=False),
)
NO_ISOLATION = LEVELS[-1]


def _everywhere(_: IsolationLevel) -> bool:
    return True


def _isolates(isolation_level: IsolationLevel) -> bool:
    return isolation_level.isolates


def _under_own_root(isolation_level: IsolationLevel) -> bool:
    return isolation_level.own_root


PROMISES = (
    Promise(
        "The mark is decided in a process that runs no student code, from numbers that are checked there", _everywhere
    ),
    Promise(
        "No answer, a malformed, late or early answer is a lost check, never a pass; a failure of the grader is never a zero",
        _everywhere,
    ),
    Promise("Nothing from a submission is written unescaped: pages, CSV, XML, terminal, CI commands", _everywhere),
    Promise("Archives and links never lead out of the submission", _everywhere),
    Promise("A submission ends within its time, and its memory is limited per process", _everywhere),
    Promise(
        "It reads no hidden trace, rubric, seed, other submission, file of a user or file of the grader", _isolates
    ),
    Promise("It changes nothing outside its scratch folder", _isolates),
    Promise("No network, no other process, nothing left running or lying about", _isolates),
    Promise("It cannot tell which other paths exist on the host", _under_own_root),
    Promise("Its disk space is limited in all", _under_own_root),
)


def named(name: str) -> IsolationLevel | None:
    """Return the isolation level of this name, as a user writes it; None if no level has it."""
    return next((isolation_level for isolation_level in LEVELS if isolation_level.name == name), None)
