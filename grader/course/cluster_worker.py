"""What runs in a worker process of a Dask cluster: one warm marker, opened for the run that it works for."""

from __future__ import annotations

import json
import pickle
import platform
import threading
from collections.abc import Mapping
from contextlib import AbstractContextManager, suppress
from importlib.metadata import version
from typing import Any, ClassVar

from distributed import Worker, WorkerPlugin, get_worker

from grader import __version__
from grader.course.pool import Marking, words
from grader.engine.results import Result, to_dict
from grader.ground.errors import GraderError, RequestError
from grader.intake import Submission

_NUMBERS_DEPEND_ON = ("mujoco", "numpy", "scipy", "matplotlib")


def versions() -> dict[str, str]:
    """What has to be the same on every machine that marks one class."""
    python = ".".join(platform.python_version_tuple()[:2])
    return {"imugrade": __version__, "python": python, **{name: version(name) for name in _NUMBERS_DEPEND_ON}}


def plain(result: Result) -> dict[str, Any]:
    """A result as it travels: text, bytes and numbers."""
    record = json.dumps(to_dict(result), ensure_ascii=True, allow_nan=False)
    return {"record": record, "charts": result.evidence.charts, "fingerprint": list(result.evidence.fingerprint)}


def mark(run: str, submission: Mapping[str, Any]) -> dict[str, Any]:
    """Mark one submission for a run whose seat has been set up here: the task that is handed to the cluster."""
    seat = get_worker().plugins[run]
    assert isinstance(seat, Seat)
    return seat.mark(Submission(**submission))


class Seat(WorkerPlugin):
    """A run's place in a worker process; Dask sets one up in every worker that there is or will be.

    A process has one marker: pytest and the filter of warnings belong to all of its threads. It goes over to another run
    where a run was killed and could not close it.

    Parameters
    ----------
    run
        The name of the run.
    made_by
        The versions of the machine that hands out.
    open_marker
        Pickled, so that it is unpacked only where the versions agree.
    """

    _at_work: ClassVar[threading.Lock] = threading.Lock()
    _taken_by: ClassVar[Seat | None] = None

    def __init__(self, run: str, made_by: Mapping[str, str], open_marker: bytes) -> None:
        self.name = run
        self._made_by = dict(made_by)
        self._open_marker = open_marker
        self._address = ""
        self._over = False
        self._opened: AbstractContextManager[Marking] | None = None
        self._marker: Marking | None = None

    def setup(self, worker: Worker) -> None:
        self._address = worker.address
        self._agree()

    def teardown(self, worker: Worker) -> None:
        self._over = True
        self._leave_if_idle()

    def mark(self, submission: Submission) -> dict[str, Any]:
        """The result as plain data, or what failed under "trouble"; the next submission then gets a fresh marker.

        Raises
        ------
        GraderError, RequestError
            If no marker can be opened here.
        """
        try:
            with self._at_work:
                return self._marked(self._seated(), submission)
        finally:
            if self._over:
                self._leave_if_idle()

    def _marked(self, marker: Marking, submission: Submission) -> dict[str, Any]:
        try:
            return plain(marker.mark(submission))
        except Exception as problem:
            self._leave()
            return {"trouble": words(problem)}

    def _agree(self) -> None:
        for name, here in versions().items():
            there = self._made_by.get(name, "none")
            if here != there:
                raise RequestError(
                    f"worker {self._address} has {name} {here}, this machine has {there}; install the same on both"
                )

    def _seated(self) -> Marking:
        if self._marker is None:
            self._agree()
            if Seat._taken_by is not None:
                Seat._taken_by._leave()
            try:
                self._opened = pickle.loads(self._open_marker)()
                self._marker = self._opened.__enter__()
            except (RequestError, GraderError) as problem:
                raise type(problem)(f"worker {self._address}: {problem}") from problem
            Seat._taken_by = self
        return self._marker

    def _leave(self) -> None:
        opened, self._opened, self._marker = self._opened, None, None
        Seat._taken_by = None
        if opened is not None:
            with suppress(Exception):  # it is given up because it failed
                opened.__exit__(None, None, None)

    def _leave_if_idle(self) -> None:
        """Who is at work leaves afterwards."""
        if self._at_work.acquire(blocking=False):
            try:
                if Seat._taken_by is self:
                    self._leave()
            finally:
                self._at_work.release()
