"""A class on a Dask cluster of this machine: a scheduler and workers that are processes of their own, and are killed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from distributed import Client

from grader.base.errors import GraderError, RequestError
from grader.course.markers import cluster, cluster_worker
from grader.course.markers.pool import KILLED, Bounds, MarkerAnswer, Unmarked
from grader.course.record.store import Store
from grader.course.run import classroom, submissions
from grader.course.run.grade_request import GradeRequest
from grader.engine import rubric
from grader.engine.chart_data import Evidence
from grader.engine.results import Result
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.durability import hand_in, recorded, results
from tests.fake_results import FakeMarker, Nobody, fake_marker, submission

ROOT = Path(__file__).parent.parent
WITHIN_S = 60.0


class Site:
    """A scheduler and its workers, started as an instructor would."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._file = folder / "scheduler.json"
        self._workers: list[subprocess.Popen[bytes]] = []
        self.scheduler = self._start("scheduler", "--port", "0", "--scheduler-file", str(self._file))
        until(lambda: self._file.exists() and self._file.read_text(encoding="utf-8").rstrip().endswith("}"))
        self.address = json.loads(self._file.read_text(encoding="utf-8"))["address"]

    def _start(self, *arguments: str) -> subprocess.Popen[bytes]:
        environment = {"PYTHONPATH": str(ROOT), "DASK_TEMPORARY_DIRECTORY": str(self._folder)}
        environment |= {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}
        with open(self._folder / "log", "ab") as log:
            command = [sys.executable, "-m", "dask", *arguments, "--host", "127.0.0.1", "--no-dashboard"]
            return subprocess.Popen(command, cwd=self._folder, env=os.environ | environment, stdout=log, stderr=log)

    def staff(self, count: int) -> list[int]:
        """Have this many workers; their process ids."""
        self._workers = [worker for worker in self._workers if worker.poll() is None]
        while len(self._workers) > count:
            worker = self._workers.pop()
            worker.kill()
            worker.wait()
        while len(self._workers) < count:
            self._workers.append(self._start("worker", self.address, "--nthreads", "1", "--no-nanny"))
        with self.client() as client:
            until(lambda: len(client.nthreads()) == count)
        return [worker.pid for worker in self._workers]

    def client(self) -> Client:
        return Client(self.address, set_as_default=False)

    def close(self) -> None:
        for process in (*self._workers, self.scheduler):
            process.kill()
            process.wait()


def until(holds: object) -> None:
    end = time.monotonic() + WITHIN_S
    while not holds():  # type: ignore[operator]
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with closing(Site(tmp_path_factory.mktemp("site"))) as site:
        yield site


def grade(site: Site, folder: Path, *ids: str) -> dict[str, MarkerAnswer]:
    marked = list(cluster.mark_all(iter(map(submission, ids)), partial(fake_marker, folder), site.address, Bounds()))
    assert len({each.id for each, _ in marked}) == len(marked), "a submission came back twice"
    return {each.id: outcome for each, outcome in marked}


# --- a class ------------------------------------------------------------------------------------------------------------


class AfterOne(Nobody):
    """Does something when the first result has come, and keeps whose results came."""

    def __init__(self, act: Callable[[], object]) -> None:
        self._act = act
        self.told: list[str] = []

    def done(self, id_: str, result: Result, *, resumed: bool) -> None:
        self.told.append(id_)
        if len(self.told) == 1:
            self._act()


def kill_one_at_work(client: Client, pids: dict[str, int]) -> bool:
    busy = [address for address, keys in client.processing().items() if keys]
    if busy:
        os.kill(pids[busy[0]], 9)
    return bool(busy)


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> GradeRequest:
    """A class that was graded on this machine."""
    root = tmp_path_factory.mktemp("here")
    students = hand_in(root / "class", full=False)
    order = GradeRequest((students,), root / "out", rubric.load(LAB), bundles.shipped(), jobs=1, trusted=True)
    classroom.grade_class(order, submissions.find(order), Nobody())
    return order


def assert_same(there: Path, here: Path) -> None:
    assert results(there) == results(here)
    assert evidence(there) == evidence(here)
    assert (there / "gradebook.csv").read_bytes() == (here / "gradebook.csv").read_bytes()


def evidence(out: Path) -> tuple[object, ...]:
    """What is recorded beside the results."""
    with Store(out) as store:
        charts, fingerprints = {id_: store.charts(id_) for id_ in store.present()}, store.fingerprints()
    assert all(fingerprints.values())
    assert any(charts.values())
    return charts, fingerprints


@pytest.mark.weekly
def test_a_worker_is_killed_at_work_and_the_results_are_those_of_this_machine(
    site: Site, here: GradeRequest, tmp_path: Path
) -> None:
    site.staff(2)
    order = replace(here, out=tmp_path / "there")
    found = submissions.find(order)
    with site.client() as client:
        killer = threading.Thread(target=until, args=[partial(kill_one_at_work, client, client.run(os.getpid))])
        screen = AfterOne(killer.start)
        outcome = classroom.grade_class(replace(order, cluster=site.address), found, screen)
        killer.join()
        assert len(client.nthreads()) == 1
    assert sorted(screen.told) == sorted(outcome.results)
    assert outcome.incomplete == []
    assert all(result.evidence == Evidence() for result in outcome.results.values())  # recorded, not remembered
    assert_same(tmp_path / "there", here.out)
    assert recorded(tmp_path / "there") == len(outcome.results) == 4


@pytest.mark.weekly
def test_a_scheduler_is_killed_midway_and_the_same_command_on_another_one_ends_with_the_results_of_this_machine(
    site: Site, here: GradeRequest, tmp_path: Path
) -> None:
    order = replace(here, out=tmp_path / "there")
    found = submissions.find(order)
    with closing(Site(tmp_path)) as first:
        first.staff(1)
        with pytest.raises(GraderError, match="was lost; give the same command again"):
            classroom.grade_class(replace(order, cluster=first.address), found, AfterOne(first.scheduler.kill))
    before = recorded(tmp_path / "there")
    assert 1 <= before < 4
    site.staff(1)
    outcome = classroom.grade_class(replace(order, cluster=site.address), found, Nobody())
    assert (outcome.resumed, outcome.incomplete) == (before, [])
    assert_same(tmp_path / "there", here.out)


# --- how submissions are handed out ---------------------------------------------------------------------------------


def test_a_submission_that_kills_two_markers_is_handed_back_and_no_worker_is_lost(site: Site, tmp_path: Path) -> None:
    pids = site.staff(2)
    outcomes = grade(site, tmp_path, "a", "kill", "b", "c")
    assert outcomes.pop("kill") == Unmarked(KILLED)
    assert all(isinstance(outcome, Result) for outcome in outcomes.values())
    assert FakeMarker(tmp_path).marked().count("kill") == 2
    assert site.staff(2) == pids


# --- what is refused, in one line -----------------------------------------------------------------------------------


def refusal(address: str, opener: object = partial(fake_marker, Path())) -> str:
    started = time.monotonic()
    with pytest.raises(RequestError) as refused:
        list(cluster.mark_all(iter([submission("a")]), opener, address, Bounds()))  # type: ignore[arg-type]
    assert time.monotonic() - started < 2 * cluster.ANSWERS_WITHIN_S
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_a_worker_with_other_versions_is_refused(site: Site, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    site.staff(1)
    ours = cluster_worker.versions(LAB.packages)
    assert "imugrade" in ours
    monkeypatch.setattr(cluster_worker, "versions", lambda _: {**ours, "mujoco": "9.9"})
    told = refusal(site.address, partial(fake_marker, tmp_path))
    assert told.startswith(f"--cluster {site.address}: worker tcp://127.0.0.1:")
    assert told.endswith(f" has mujoco {ours['mujoco']}, this machine has 9.9; install the same on both")
    assert not (tmp_path / "marked").exists()


def test_a_worker_that_cannot_isolate_is_refused(site: Site) -> None:
    site.staff(1)
    told = refusal(site.address, partial(classroom.guarded_marker, rubric.load(LAB), bundles.shipped(), "none", False))
    assert "this machine cannot isolate students' code" in told


def test_a_cluster_without_workers_is_refused(site: Site) -> None:
    site.staff(0)
    assert refusal(site.address) == (
        f"--cluster {site.address}: it has no worker; start some with: dask worker {site.address} --nthreads 1"
    )


@pytest.mark.parametrize(
    ("address", "reason"),
    [("tcp://127.0.0.1:1", "nothing came within 0.5 s"), ("nowhere", "missing port number in address 'nowhere'")],
)
def test_an_address_where_no_scheduler_is_is_refused(
    monkeypatch: pytest.MonkeyPatch, address: str, reason: str
) -> None:
    monkeypatch.setattr(cluster, "ANSWERS_WITHIN_S", 0.5)
    assert refusal(address).startswith(f"--cluster {address}: no Dask scheduler answers there ({reason}")


def test_without_dask_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert refusal("tcp://127.0.0.1:1") == "--cluster needs Dask; install it with: pip install 'imugrade[cluster]'"


# --- a cluster that goes away -----------------------------------------------------------------------------------------


def test_a_scheduler_that_goes_away_ends_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "ANSWERS_WITHIN_S", 2.0)
    with closing(Site(tmp_path)) as site:
        site.staff(1)
        killer = threading.Thread(target=lambda: (until((tmp_path / "marked").exists), site.scheduler.kill()))
        killer.start()
        with pytest.raises(GraderError) as told:
            grade(site, tmp_path, "wait")
        killer.join()
    assert str(told.value) == (
        f"the cluster at {site.address} was lost; give the same command again, and it continues where it stopped"
    )
