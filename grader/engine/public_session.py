"""Messages about loading a submission without hidden data: it is loaded again in a process with public data only.

When hidden scenarios are graded, hidden data is in a process's folder before any student code runs there. So text that this code
can choose (messages, type names, file names, lines, counts) may hold hidden numbers, and is never shown. A student still has to
learn why a file does not load. For that the submission is loaded once more, with the lab's public files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from grader.base.errors import GraderError, NoAnswer, RequestError
from grader.engine.findings import Missing
from grader.engine.submission_session import SubmissionSession


class PublicSession:
    """Sandbox session about a submission with public data only: its messages hold no hidden data, so students may read them.

    The first use calls `start`, which opens the session. If it raises a RequestError or GraderError, the methods give None or [].
    """

    def __init__(self, start: Callable[[], SubmissionSession]) -> None:
        self._start = start
        self._started: list[SubmissionSession] = []
        self._failed = False

    def missing(self, name: str) -> Missing | None:
        """Return why, with public data, no file defines the function or class `name`; None if a file does or no answer came."""
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
        """Return the notes about loading the files that define these functions and classes of the lab; [] if no session opened."""
        for name in names:
            self.missing(name)
        return self._started[0].notes if self._started else []

    def close(self) -> None:
        for student in self._started:
            student.close()

    def _session(self) -> SubmissionSession | None:
        if not self._started and not self._failed:
            try:
                self._started.append(self._start())
            except (RequestError, GraderError):
                self._failed = True
        return self._started[0] if self._started else None
