"""Show a submission's checks as pytest tests: found without running anything, judged by `imugrade check` in another process.

Nothing of the submission is imported here, and no other test is collected beside its checks.
"""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from grader.base.errors import RequestError
from grader.base.files import seen_from
from grader.base.text import printable
from grader.engine import rubric as rubrics
from grader.engine.lab import Part
from grader.engine.lab_registry import chosen_lab
from grader.engine.results import CheckResult, Result, from_dict
from grader.engine.rubric import Rubric
from grader.intake import Submission, read_submission
from grader.platforms.places import FileLine, find_places
from grader.pytest_plugin.options import PluginOptions, options_of
from grader.pytest_plugin.reporting import CheckFailure, NotJudgedError
from grader.report import words

_CODE = ("-c", "import sys; from grader.cli import main; sys.exit(main())")


class PluginRun:
    """The hooks of one `pytest --imugrade` run: it finds the checks, has the submission graded once, and prints the points."""

    def __init__(self, config: pytest.Config) -> None:
        try:
            self.lab = chosen_lab()
            self._asked: PluginOptions = options_of(config.option.file_or_dir, self.lab.titles)
            given = config.option.imugrade_rubric
            self._rubric_path = None if given is None else Path(os.path.abspath(given))
            self._rubric: Rubric = rubrics.load(self.lab, self._rubric_path)
            self._submission: Submission = read_submission(self._asked.path, self.lab.files)
            self._name = printable(self._submission.name, words.NAME_LIMIT)
        except RequestError as problem:
            raise pytest.UsageError(f"imugrade: {problem}") from None
        if self._submission.status != "ready":
            said = " ".join((words.STATUS[self._submission.status], *self._submission.notes))
            raise pytest.UsageError(f"imugrade: {self._name}: {said}")
        self.path = Path(os.path.abspath(self._asked.path))
        self.places = find_places(self.lab, self._submission, self.path, self.path)

    def pytest_report_header(self) -> str:
        return f"imugrade: {self._name}, public scenarios"

    def pytest_collection(self, session: pytest.Session) -> bool | None:
        """Collect the checks that the arguments name, in place of test files; raise pytest's UsageError if there are none.

        Return True, which ends pytest's own collection; None under pytest-xdist, whose workers collect.
        """
        if session.config.pluginmanager.hasplugin("dsession"):
            return None  # with pytest-xdist the workers collect
        session.perform_collect([])
        if not session.items and not session.config.option.deselect:
            raise pytest.UsageError("imugrade: no check has this name; `imugrade explain` lists them")
        return True

    @pytest.hookimpl(tryfirst=True)
    def pytest_make_collect_report(self, collector: pytest.Collector) -> pytest.CollectReport | None:
        """Return the session's CollectReport, with student files in place of test files; None leaves other collectors to pytest."""
        if not isinstance(collector, pytest.Session):
            return None
        files: dict[Path, list[str]] = {}
        for part in self._parts():
            files.setdefault(self._file_of(part.names[0]), []).append(part.id)
        nodes: list[pytest.Item | pytest.Collector] = [
            _File.from_parent(collector, path=path, plugin_run=self, criteria=held) for path, held in files.items()
        ]
        return pytest.CollectReport(collector.nodeid, "passed", None, nodes)

    def _parts(self) -> Iterator[Part]:
        """Yield the criteria and extensions that have checks; an extension that was not attempted is left out."""
        for each in self._rubric.parts:
            part = self.lab.part(each.id)
            if part and each.checks and (part in self.lab.parts or part.attempted_in(self._submission.files)):
                yield part

    def _file_of(self, name: str) -> Path:
        """Return the file that defines a required name, or in which the lab expects it; for an archive, the archive itself.

        A notebook stands in for an expected file that is missing.
        """
        home, files = self.lab.homes[name], self._submission.files
        notebook = next((file for file in files if file.endswith(".ipynb")), home)
        at = self.places.definitions.get(name, FileLine(self._submission.origin(home if home in files else notebook)))
        return self.path / at.file if self.path.is_dir() else self.path

    def checks(self, criterion: str, file: Path) -> Iterator[str]:
        """Yield the names of a criterion's checks, listed under the student's `file`, that the arguments of pytest select."""
        for weight in self._rubric.checks:
            part, _, name = weight.id.partition(".")
            if part == criterion and self._asked.wants(file, part, name):
                yield name

    @functools.cached_property
    def result(self) -> Result:
        """Return the result of the whole submission, from `imugrade check` in a process that this run cannot disturb.

        If that fails, stop pytest with its message and exit code.
        """
        with tempfile.TemporaryDirectory(prefix="imugrade-") as private:
            file = Path(private, "result.json")
            asked = ["check", str(self.path), "--json", str(file)]
            asked += [] if self._rubric_path is None else ["--rubric", str(self._rubric_path)]
            ended = subprocess.run(
                [sys.executable, *_CODE, *asked],
                cwd=private,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                check=False,
            )
            if not file.is_file():
                said = ended.stderr.decode("utf-8", "replace").strip()
                pytest.exit(printable(said, words.TEXT_LIMIT, newlines=True), returncode=ended.returncode or 3)
            return from_dict(json.loads(file.read_bytes()))

    @functools.cached_property
    def found(self) -> Mapping[str, CheckResult]:
        return {check.id: check for part in self.result.parts for check in part.checks}

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Print the points of the tests that ran, by criterion. Each test's report holds its points, also under pytest-xdist."""
        ran: dict[str, Mapping[str, Any]] = {}
        for report in (each for reports in terminalreporter.stats.values() for each in reports):
            told = dict(getattr(report, "user_properties", ()))
            if "points" in told and report.when == "call":
                ran[report.nodeid] = told  # a check that ran again counts once
        sums: dict[str, list[float]] = {}
        for check in ran.values():
            earned = sums.setdefault(check["criterion"], [0.0, 0.0])
            earned[0] += check["points"]
            earned[1] += check["max_points"]
        if not sums:
            return
        terminalreporter.section("imugrade")
        titles = {part.id: part.title for part in self._rubric.parts}
        rows = [(titles[id_], words.fraction(*sums[id_])) for id_ in titles if id_ in sums]
        marked = {part.id for part in self._rubric.criteria} & sums.keys()
        rows += [("Score of what ran", words.fraction(*(sum(sums[id_][end] for id_ in marked) for end in (0, 1))))]
        width = max(len(title) for title, _ in rows)
        for title, points in rows:
            terminalreporter.line(f"{title.ljust(width)}  {points}")


class _File(pytest.File):
    """One file of the student's, with the criteria whose functions it defines or should define."""

    def __init__(self, *, plugin_run: PluginRun, criteria: list[str], **options: Any) -> None:
        super().__init__(**options)
        self._plugin_run, self._held = plugin_run, criteria

    def collect(self) -> Iterator[pytest.Collector]:
        for criterion in self._held:
            yield _Criterion.from_parent(self, name=criterion, plugin_run=self._plugin_run)


class _Criterion(pytest.Collector):
    """One criterion or extension in pytest's tree of tests, which collects the checks below it."""

    def __init__(self, *, plugin_run: PluginRun, **options: Any) -> None:
        super().__init__(**options)
        self._plugin_run = plugin_run

    def collect(self) -> Iterator[pytest.Item]:
        for name in self._plugin_run.checks(self.name, self.path):
            yield _Check.from_parent(self, name=name, plugin_run=self._plugin_run)


class _Check(pytest.Item):
    """One check as a test, which passes, fails or is skipped as the check did."""

    def __init__(self, *, plugin_run: PluginRun, **options: Any) -> None:
        super().__init__(**options)
        assert self.parent is not None
        self._plugin_run, self._criterion, self._has_run = plugin_run, self.parent.name, False

    def setup(self) -> None:
        """Raise an error, not a failure, if the grader could not judge the check."""
        if self._found.outcome == "not_judged":
            raise NotJudgedError(self._found.message)

    def runtest(self) -> None:
        check = self._found
        if self._has_run:  # again, for another plugin: JUnit's file holds the properties of each run
            self.user_properties.clear()
        else:
            self.user_properties += [
                ("criterion", self._criterion),
                ("points", check.points),
                ("max_points", check.max_points),
                ("outcome", check.outcome),
                *(("fault", id_) for id_ in check.misconceptions if id_ not in words.FOR_THE_INSTRUCTOR),
            ]
        self._has_run = True
        if check.outcome == "skipped":
            pytest.skip(printable(check.message, words.TEXT_LIMIT))
        if check.outcome != "passed":
            raise AssertionError(check.id)

    @property
    def _found(self) -> CheckResult:
        return self._plugin_run.found[f"{self._criterion}.{self.name}"]

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return the check's message, placed at the student's own line, without the grader's frames."""
        if isinstance(excinfo.value, AssertionError) and excinfo.value.args == (self._found.id,):
            return CheckFailure(self._found, self._plugin_run.lab, *self._where())
        if isinstance(excinfo.value, NotJudgedError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def _where(self) -> tuple[str, int]:
        """Return file and line of a failure: where code raised, else the checked definition, else the file's first line."""
        place = self._plugin_run.places.line_for(self._found)
        if place is None:
            return self.nodeid.partition("::")[0], 1
        return seen_from(self.config.rootpath, self._plugin_run.path / place.file), place.line or 1

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return where editors and reports place the test: at the definition that is checked, in lines that count from 0."""
        at = self._plugin_run.places.definitions.get(
            self._plugin_run.lab.name_of(f"{self._criterion}.{self.name}"), FileLine("")
        )
        return self.path, (at.line or 1) - 1, f"{self._criterion}::{self.name}"
