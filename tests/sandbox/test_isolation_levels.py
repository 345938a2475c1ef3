"""The choice of levels: what this machine allows, how a sandbox chooses, and who else can use it."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import select
import signal
import subprocess
import sys
import venv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from grader.base.errors import GraderError
from grader.sandbox import level_choice, surroundings
from grader.sandbox.isolation_levels import LEVELS, PROMISES, IsolationLevel
from grader.sandbox.launch import Zygote
from grader.sandbox.level_choice import LevelResult
from grader.sandbox.plan import Contents
from grader.sandbox.process import IsolationRefusedError
from grader.sandbox.sandbox import Sandbox

from .conftest import WORKER_CODE, run

ROOT = Path(__file__).parents[2]
PLAIN_UID = 12345


def test_every_level_is_probed_best_first_and_the_lowest_always_holds(isolation_levels: dict[str, LevelResult]) -> None:
    assert list(isolation_levels) == ["full", "bubblewrap", "landlock", "none"]
    assert isolation_levels["none"].usable
    assert all(isolation_level.usable or isolation_level.reason for isolation_level in isolation_levels.values())


def test_security_md_promises_what_the_levels_do_and_a_better_one_keeps_all_that_a_lower_one_does() -> None:
    kept = [{each.words for each in PROMISES if each.kept_on(isolation_level)} for isolation_level in LEVELS]
    assert all(better >= lower for better, lower in itertools.pairwise(kept))
    assert [isolation_level.isolates for isolation_level in LEVELS] == [True, True, True, False]
    rows = [(each.words, *("yes" if each.words in its else "no" for its in kept)) for each in PROMISES]
    promised = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    assert promised in (ROOT / "SECURITY.md").read_text(encoding="utf-8")


def refuse(*names: str) -> Callable[..., Any]:
    real = level_choice.start_zygote

    def start_zygote(isolation_level: IsolationLevel, *rest: Any) -> Any:
        if isolation_level.name in names:
            raise IsolationRefusedError(f"no {isolation_level.name} today")
        return real(isolation_level, *rest)

    return start_zygote


@pytest.mark.parametrize(
    ("level", "why"),
    [
        ("landlock", "full: no full today; bubblewrap: no bubblewrap today"),
        ("none", "full: no full today; bubblewrap: no bubblewrap today; landlock: no landlock today"),
    ],
)
def test_a_sandbox_on_a_lower_level_works_and_says_why_it_is_not_on_a_higher_one(
    monkeypatch: pytest.MonkeyPatch, isolation_levels: dict[str, LevelResult], level: str, why: str
) -> None:
    if not isolation_levels[level].usable:
        pytest.skip(isolation_levels[level].reason)
    monkeypatch.setattr(level_choice, "start_zygote", refuse(*re.findall(r"(\w+):", why)))
    with Sandbox(Contents(WORKER_CODE)) as sandbox, sandbox.worker() as worker:
        assert (sandbox.isolation_level.name, sandbox.why) == (level, why)
        assert run(worker, "result = 1") == {"result": 1}


def test_a_level_that_is_asked_for_and_cannot_be_had_is_never_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(level_choice, "start_zygote", refuse("full"))
    with pytest.raises(GraderError, match="does not allow the isolation level 'full': no full today"):
        Sandbox(Contents(WORKER_CODE), isolation_level="full")


def test_the_isolation_is_tried_against_a_file_of_the_grader_that_is_there() -> None:
    decoy = Path(surroundings.decoy())
    assert decoy.is_file()
    assert any(decoy.is_relative_to(folder) for folder in surroundings.hidden())
    assert str(decoy) not in surroundings.code()


def test_an_isolation_that_does_not_hold_when_tried_is_refused(
    monkeypatch: pytest.MonkeyPatch, isolating_sandbox: Sandbox
) -> None:
    """The decoy is readable here, as if the isolation had a hole: the trial from inside must notice."""
    monkeypatch.setattr("grader.sandbox.surroundings.decoy", lambda: os.__file__)
    with pytest.raises(IsolationRefusedError, match="the grader's files could be read"):
        level_choice.start_zygote(isolating_sandbox.isolation_level, Contents(WORKER_CODE))


@pytest.mark.parametrize("times", [1, 2])
@pytest.mark.parametrize(
    "isolation_level",
    [isolation_level for isolation_level in LEVELS if isolation_level.isolates and not isolation_level.program],
    ids=lambda isolation_level: isolation_level.name,
)  # what bwrap started outlives it, and goes on
def test_a_zygote_that_is_killed_before_it_is_isolated_is_no_lower_level(
    monkeypatch: pytest.MonkeyPatch, sandbox_on: Callable[[str], Sandbox], isolation_level: IsolationLevel, times: int
) -> None:
    sandbox_on(isolation_level.name)
    kills, await_isolation = iter(range(times)), Zygote._await_isolation

    def killed(zygote: Zygote) -> None:
        if next(kills, None) is not None:
            os.kill(zygote.pid, signal.SIGKILL)
            with contextlib.suppress(OSError):
                while zygote._control.recv(1 << 20):  # what it had said so far, until nobody is there any more
                    pass
        await_isolation(zygote)

    monkeypatch.setattr(Zygote, "_await_isolation", killed)
    if times == 1:
        level_choice.start_zygote(isolation_level, Contents(WORKER_CODE)).close()
    else:
        with pytest.raises(IsolationRefusedError, match="it was killed before it was isolated, twice"):
            level_choice.start_zygote(isolation_level, Contents(WORKER_CODE))


def test_a_plain_user_has_the_same_isolation() -> None:
    if os.geteuid() != 0:
        pytest.skip("these tests run as a plain user already")
    if not _can_be_used_by_all(Path(sys.executable)):
        pytest.skip("this Python lies where only root may go")
    ids: dict[str, Any] = {"user": PLAIN_UID, "group": PLAIN_UID, "extra_groups": []}
    command = [sys.executable, "-m", "tests.sandbox.smoke"]
    out = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, **ids)
    lines = out.stdout.splitlines()
    assert lines, out.stderr
    assert all(line.endswith(f" {PLAIN_UID} True") for line in lines)


def test_packages_may_lie_where_only_the_environment_says(
    tmp_path: Path, isolation_levels: dict[str, LevelResult]
) -> None:
    """A Python that has no package of its own, and finds them by PYTHONPATH."""
    import numpy as np

    venv.create(tmp_path, symlinks=True)
    environment = {**os.environ, "PYTHONPATH": str(Path(np.__file__).parents[1])}
    command = [tmp_path / "bin/python", "-m", "tests.sandbox.smoke"]
    out = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, env=environment)
    assert out.returncode == 0, out.stderr
    held = [line.split()[0] for line in out.stdout.splitlines() if line.endswith(" True")]
    assert held == [name for name, tried in isolation_levels.items() if tried.usable and tried.isolation_level.isolates]


def _can_be_used_by_all(program: Path) -> bool:
    places = [*program.parents, *program.resolve().parents, *ROOT.parents]
    return all(place.stat().st_mode & 0o005 == 0o005 for place in places)


def test_when_the_grader_is_killed_everything_it_started_ends(sandbox: Sandbox, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tests.sandbox.smoke", sandbox.isolation_level.name]
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, env=environment) as lingering:
        assert lingering.stdout is not None
        pidfds = [os.pidfd_open(int(pid)) for pid in lingering.stdout.readline().split()]
        lingering.kill()
    for pidfd in pidfds:
        ended, _, _ = select.select([pidfd], [], [], 10)
        os.close(pidfd)
        assert ended
    if sandbox.isolation_level.isolates:
        assert list(tmp_path.iterdir()) == []
