"""Words about loading a submission that hold no hidden data: they come from processes that were given public data alone.

Under a secret the hidden robot lies in a worker's folder before any of the student's code runs. So whatever that code can choose
(messages, type names, file names, lines, counts) may hold hidden numbers from the first import on, and is never told. A student
still has to learn why a file does not import. For that the submission is loaded once more, with the public robot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from grader.base.errors import GraderError, NoAnswer, RequestError
from grader.engine.findings import Missing
from grader.engine.submission_session import Conversation


class PublicLook:
    """A session over the same files that never saw hidden data; it starts when it is asked for the first time.

    Parameters
    ----------
    start : starts the session; it may raise RequestError or GraderError where no public data can be had here
    """

    def __init__(self, start: Callable[[], Conversation]) -> None:
        self._start = start
        self._started: list[Conversation] = []
        self._failed = False

    def missing(self, name: str) -> Missing | None:
        """Return why `name` is missing beside public data as well; None where it is there, or where that cannot be told."""
        student = self._session()
        if student is None:
            return None
        try:
            student.retried(lambda: student.place_of(name))
        except Missing as missing:
            return missing
        except (NoAnswer, GraderError):
            pass
        return None

    def notes(self, names: Iterable[str]) -> list[str]:
        """Return the notes about loading the files that define these names."""
        for name in names:
            self.missing(name)
        return self._started[0].notes if self._started else []

    def close(self) -> None:
        for student in self._started:
            student.close()

    def _session(self) -> Conversation | None:
        if not self._started and not self._failed:
            try:
                self._started.append(self._start())
            except (RequestError, GraderError):
                self._failed = True
        return self._started[0] if self._started else None
