"""Grading of a class on a running Dask cluster: each worker process grades one submission at a time.

If a worker is lost, Dask gives its submission to another one. Submissions and results travel as plain data. Rubric and traces
(reference recordings) go once to every worker.
"""

from __future__ import annotations

import asyncio
import json
import logging
import pickle
import queue
import uuid
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any

from grader.base.errors import GraderError, RequestError, fault_text
from grader.base.text import printable
from grader.course.markers.pool import KILLED, Backlog, Bounds, MarkerAnswer, OpenMarker, Task, Unmarked
from grader.engine.chart_data import Evidence
from grader.engine.lab_registry import chosen_lab
from grader.engine.results import Result, from_dict
from grader.intake import Submission

if TYPE_CHECKING:
    from distributed import Client, Future

    from grader.course.markers.cluster_worker import GradingPlugin

ANSWERS_WITHIN_S = 5.0
POLL_S = 5.0
NO_WORKERS_TIMEOUT_S = 120.0
"""Seconds that a cluster may be without any worker. A batch system that restarts an ended job soon does so within this time."""
_FETCHED_WITHIN_S = 60.0
_SETTINGS = {
    "distributed.admin.large-graph-warning-threshold": "1 GiB"
}  # a submission with many pictures is no mistake


def mark_all(
    submissions: Iterator[Submission], open_marker: OpenMarker, address: str, bounds: Bounds
) -> Generator[tuple[Submission, MarkerAnswer], None, None]:
    """Grade every submission on a cluster; yield each with its outcome once it is known, in any order.

    The outcome is a result, `Unmarked` if the grader itself failed, or `Ended` if a limit was exceeded.

    Parameters
    ----------
    submissions
        Taken as workers are free, so that a class need not fit into memory. Without submissions, no cluster is needed.
    open_marker
        Opens a marker, which grades submissions; called in each worker process, so it must be picklable.
    address
        Address of the Dask scheduler, as "tcp://host:8786" or "tls://host:8786". Dask's configuration names the certificates.
    bounds
        Time and memory beyond which the grading of one submission is ended.

    Raises
    ------
    RequestError
        If Dask is not installed, no cluster answers at `address`, or one of its workers cannot grade this class.
    GraderError
        If the cluster is lost, or has no worker for `NO_WORKERS_TIMEOUT_S`.
    """
    first = next(submissions, None)
    if first is None:  # all on record: no cluster is needed
        return
    with _connected(address) as client, _grading_plugins(client, open_marker, bounds, address) as run:
        yield from _Tasks(client, run, address, chain([first], submissions)).run()


@contextmanager
def _reporting_lost_scheduler(address: str) -> Iterator[None]:
    """Turn any exception in this ``with`` block into a GraderError: the cluster was lost, and the same command resumes the run."""
    try:
        yield
    except Exception as problem:
        raise _lost(address) from problem


def _lost(address: str) -> GraderError:
    return GraderError(
        f"the cluster at {address} was lost; give the same command again, and it continues where it stopped"
    )


@contextmanager
def _connected(address: str) -> Iterator[Client]:
    """Yield a client of the Dask scheduler and close it; RequestError if Dask is not installed or no scheduler answers."""
    try:
        import dask  # noqa: PLC0415 - an extra
        from distributed import Client  # noqa: PLC0415
    except ImportError:
        raise RequestError("--cluster needs Dask; install it with: pip install 'imugrade[cluster]'") from None
    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # our own errors say in one line what went wrong
    try:
        asyncio.run(_find_scheduler(address))
    except _NoSchedulerError as problem:
        raise RequestError(f"--cluster {printable(address)}: no Dask scheduler answers there ({problem})") from None
    with dask.config.set(_SETTINGS):
        with _reporting_lost_scheduler(address):
            client = Client(address, timeout=ANSWERS_WITHIN_S, set_as_default=False)
        try:
            yield client
        finally:
            with suppress(Exception):  # the scheduler may be gone; an error here must not hide that of the run
                client.close()


class _NoSchedulerError(Exception):
    """Exception: no Dask scheduler answers at the address given by the user; the message says why."""


async def _find_scheduler(address: str) -> None:
    """Raise _NoSchedulerError unless a Dask scheduler answers soon. Dask's own client would wait for ever for a silent server."""
    from distributed import Security, rpc  # noqa: PLC0415

    try:
        options = Security().get_connection_args("client")
        async with rpc(address, connection_args=options) as other:
            identity = await asyncio.wait_for(other.identity(), ANSWERS_WITHIN_S)
    except asyncio.TimeoutError:  # before Python 3.11 this is no OSError
        raise _NoSchedulerError(f"nothing came within {ANSWERS_WITHIN_S:g} s") from None
    except (OSError, ValueError, TypeError, RuntimeError) as problem:
        raise _NoSchedulerError(printable(str(problem), 200)) from problem
    if identity["type"] != "Scheduler":
        raise _NoSchedulerError(f"it is a {printable(identity['type'], 40)}")


@contextmanager
def _grading_plugins(client: Client, open_marker: OpenMarker, bounds: Bounds, address: str) -> Iterator[str]:
    """Install a grading plugin in every Dask worker, yield the run's name for its tasks, and remove it at the end.

    RequestError if the cluster has no worker, or one that cannot grade.
    """
    from grader.course.markers.cluster_worker import GradingPlugin, versions  # noqa: PLC0415

    with _reporting_lost_scheduler(address):
        staffed = bool(client.nthreads())
    if not staffed:
        raise RequestError(
            f"--cluster {printable(address)}: it has no worker; start some with: dask worker {printable(address)} --nthreads 1"
        )
    run = f"imugrade-{uuid.uuid4().hex}"
    try:
        _set_up(
            client, GradingPlugin(run, versions(chosen_lab().packages), pickle.dumps((open_marker, bounds))), address
        )
        yield run
    finally:
        with suppress(Exception):  # the cluster may be gone, and the plugins with it
            client.unregister_worker_plugin(run)


def _set_up(client: Client, plugin: GradingPlugin, address: str) -> None:
    """Install the grading plugin on all workers; raise RequestError if one cannot grade, for example with other versions."""
    try:
        client.register_plugin(plugin)
    except RequestError as problem:
        raise RequestError(f"--cluster {printable(address)}: {problem}") from None
    except Exception as problem:
        reason = printable(fault_text(problem), 300)
        raise RequestError(
            f"--cluster {printable(address)}: a worker cannot grade ({reason}); install the same imugrade[cluster] there"
        ) from None


class _Tasks:
    """The submissions of one run on a cluster: those that wait, and the Dask tasks that grade the others.

    There are at most as many tasks as workers: when a worker dies, Dask blames every task that it had been given.
    """

    def __init__(self, client: Client, run: str, address: str, submissions: Iterator[Submission]) -> None:
        self._client, self._run, self._address = client, run, address
        self._backlog = Backlog(submissions)
        self._out: dict[Future[Any], Task] = {}
        self._done: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
        self._sent = 0

    def run(self) -> Iterator[tuple[Submission, MarkerAnswer]]:
        """Grade all submissions on the cluster; yield each with its outcome as soon as it is known."""
        while self._hand_out():
            future = self._next_done()
            task = self._out.pop(future)
            outcome = self._outcome(future, task)
            if outcome is not None:
                yield task.submission, outcome

    def _hand_out(self) -> bool:
        """Give every idle worker a submission; return False when no task is left to wait for, which ends the run."""
        at_once = max(1, self._workers())
        while len(self._out) < at_once and (task := self._backlog.next()) is not None:
            self._send(task)
        return bool(self._out)

    def _send(self, task: Task) -> None:
        """Start one Dask task that grades a submission; when it ends, its future enters the queue `_done`."""
        from grader.course.markers.cluster_worker import mark  # noqa: PLC0415

        self._sent += 1
        plain = {**vars(task.submission), "files": dict(task.submission.files), "above": dict(task.submission.above)}
        with _reporting_lost_scheduler(self._address):
            future = self._client.submit(mark, self._run, plain, key=f"{self._run}-{self._sent}", pure=False)
        self._out[future] = task
        future.add_done_callback(self._done.put)

    def _next_done(self) -> Future[Any]:
        """Wait for a task to end and return its future; GraderError after `NO_WORKERS_TIMEOUT_S` without any worker."""
        without_s = 0.0
        while True:
            try:
                return self._done.get(timeout=POLL_S)
            except queue.Empty:
                without_s = 0.0 if self._workers() else without_s + POLL_S
            if without_s >= NO_WORKERS_TIMEOUT_S:
                raise GraderError(
                    f"the cluster at {self._address} has had no worker for {NO_WORKERS_TIMEOUT_S:g} s; "
                    "start some, then give the same command again"
                )

    def _workers(self) -> int:
        """Return how many workers the cluster has, so that each gets one task; GraderError if the cluster is lost."""
        with _reporting_lost_scheduler(self._address):
            return len(self._client.nthreads())

    def _outcome(self, future: Future[Any], task: Task) -> MarkerAnswer | None:
        """Return the outcome of an ended task; None if it will be retried. Raise the error of a worker that cannot grade at all."""
        from distributed import KilledWorker  # noqa: PLC0415

        if future.cancelled():
            raise _lost(self._address)
        try:
            answer = future.result(timeout=_FETCHED_WITHIN_S)
        except (RequestError, GraderError):
            raise
        except KilledWorker:
            return Unmarked(KILLED)  # Dask has tried it on several
        except Exception as problem:
            return self._backlog.failed(task, fault_text(problem))
        if "trouble" in answer:
            task.stopped = answer["stopped"] or task.stopped
            return self._backlog.failed(task, answer["trouble"])
        return _result(answer)


def _result(answer: Mapping[str, Any]) -> Result:
    evidence = Evidence(answer["charts"], tuple(answer["fingerprint"]))
    return replace(from_dict(json.loads(answer["record"])), evidence=evidence)
