"""Session about one submission that finds which file defines each required name, and collects notes for the report."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any, TypeVar

from grader.base.errors import NoAnswer
from grader.base.text import enumerated, printable
from grader.engine.breakpoints import breakpoints
from grader.engine.findings import GraderText, Missing, StudentError, Where
from grader.engine.load_report import Loaded, fault_of_statement, loaded_from
from grader.engine.question import Question
from grader.engine.session import SandboxSession
from grader.sandbox.wire import Frame

_NEVER_IMPORTED = ("conftest", "sitecustomize", "usercustomize", "setup")
_LONGEST_NOTE = 500
_MOST_PLACES = 4  # files that a note lists
_MOST_BREAKPOINTS = 3
_HOW_IN_WORDS = {"hints": "was run without its type hints"}

T = TypeVar("T")


class SubmissionSession(SandboxSession):
    """Sandbox session that finds the file that defines a function or class of the lab, and asks questions about it there.

    Attributes
    ----------
    secret : whether the sandbox holds hidden data, which student code may put into any text that it can choose
    withheld_note : whether `note` left out a text for the report, as it could hold hidden data
    """

    secret = False
    withheld_note = False

    def answer(self, question: Question[T], called: str = "") -> T:
        """Return student code's answer; charts find it as `called`, if that is not "". Raise `Missing` or `NoAnswer` without it."""
        return self.once_named(called, question.key, lambda: question.becomes(self._ask_where_defined(question)))

    def _ask_where_defined(self, question: Question[Any]) -> Frame:
        place = {"path": self.place_of(question.about)}
        return self.ask(question.op, {**place, **question.fields}, question.arrays)

    def load(self, path: str) -> Loaded:
        """Load a file in the current sandbox process, unless it is loaded there, and return the report on it.

        A new process loads it again after a first crash, or if a statement to skip was found, another loaded file may be the cause,
        or the report may quote data of an earlier question. If no process can load it, each call raises the last NoAnswer.
        """
        if path in self.deadly:
            raise self.deadly[path].with_traceback(None)
        session = self._fresh_session()
        if path in session.loaded:
            return session.loaded[path]
        known = self._endings.count
        try:
            loaded = loaded_from(self.ask("load", {"path": path}), path)
        except NoAnswer as nothing:
            if not session.loaded:
                if not self._may_help_to_repeat(nothing, known, tried=path in self._suspects):
                    self.deadly[path] = nothing
                    raise
                if self._endings.count == known:
                    self._suspects.add(path)
        else:
            if loaded.is_clean or not session.has_seen_data:  # else the report may hold hidden data of a question
                session.loaded[path] = loaded
                self._answers.setdefault(("load", path), loaded)
                return loaded
        self.end_session()
        return self.load(path)

    def place_of(self, name: str) -> str:
        """Return the path of the file that defines a required name, after loading it in the current sandbox process.

        Raises
        ------
        Missing
            If no file defines the name; the message says why.
        NoAnswer
            If loading the file killed the process or did not end.
        """
        home = self._lab.homes[name]
        self._fresh_session()
        if (home in self.paths or home in self.deadly) and name in (loaded := self.load(home)).names:
            self._note_load_problems(home, loaded)
            self._note_defined_again(home, name)
            return home
        for path in self._other_files_defining(name, home):
            if name in (loaded := self.load(path)).names:
                self.used += [path] if path not in self.used else []
                self._note_load_problems(path, loaded)
                self._note_where_it_was_found(path, name, home)
                self._note_defined_again(path, name)
                return path
        raise self._why_missing(name, home)

    def _note_where_it_was_found(self, path: str, name: str, home: str) -> None:
        """Note for the report that a name was found in another file than expected; names found in one file share one note."""
        known = self._strays.get(path, {})
        strays = {each: its for each, its in self._lab.homes.items() if each in known or each == name}
        self._strays[path] = strays
        before = _strays_note(path, known)
        if before in self.notes:
            self.notes[self.notes.index(before)] = _strays_note(path, strays)
        else:
            self.note(_strays_note(path, strays))

    def _note_load_problems(self, path: str, loaded: Loaded) -> None:
        """Note once what was unusual when a file was loaded: misspelled or supplied names, breakpoints, skipped statements.

        Of the skipped statements it names the first, which usually causes the others.
        """
        if path in self._noted:
            return
        self._noted.add(path)
        for name, own in loaded.misspelled:
            self.note(f"{printable(path, 120)} defines {printable(own, 60)}; the grader used it as {name}")
        if names := ", ".join(dict.fromkeys(loaded.supplied)):
            them = "it" if "," not in names else "them"
            self.note(f"{printable(path, 120)} uses {names} without an import; the grader supplied {them}")
        for first in loaded.stepped_over[:1]:
            did = _HOW_IN_WORDS.get(first.how, "was skipped")
            more = len(loaded.stepped_over) - 1
            others = f"; so {'were' if more > 1 else 'was'} {more} more statement{'s' * (more > 1)}" if more else ""
            self.note(f"{first.where} {did}: {first.why}{others}; the rest of the file was used")
        if path.endswith(".py") and path in self.files:  # a notebook may have written a file that was not handed in
            self._note_breakpoints(path)

    def _note_defined_again(self, path: str, name: str) -> None:
        """Note which definition was graded if the submission defines a required name more than once."""
        if (key := f"{path}: {name}") in self._noted:
            return
        self._noted.add(key)
        defines = re.compile(rb'^(?:[ \t]*")?(?:async[ \t]+def|def|class)[ \t]+' + name.encode() + rb"\b", re.MULTILINE)
        code = {each: content for each, content in sorted(self.files.items()) if each.endswith((".py", ".ipynb"))}
        found = {each: count for each, content in code.items() if (count := len(defines.findall(content)))}
        if sum(found.values()) > 1:
            where = enumerated([printable(each, 80) for each in [*found][:_MOST_PLACES]])
            which = "last one" if found.get(path, 0) > 1 else "one"
            self.note(
                f"{name} is defined {sum(found.values())} times, in {where}; the {which} in {printable(path, 80)} was graded"
            )

    def _note_breakpoints(self, path: str) -> None:
        for call, line in itertools.islice(breakpoints(self.files[path]), _MOST_BREAKPOINTS):
            self.note(
                f"{printable(path, 120)}, line {line}: {printable(call, 60)}() was skipped: nobody can type during "
                "grading. A program from `imugrade repro` stops there"
            )

    def _other_files_defining(self, name: str, home: str) -> list[str]:
        """Return the files other than `home` that define a name, nearest to the submission's folder first; [] without an answer."""
        if self._outline is None:
            try:
                self._outline = self.retried(lambda: self.ask("outline", {})).fields["names"]
            except NoAnswer:
                self._outline = {}
        defining = [path for path, names in self._outline.items() if path != home and name in names]
        named = [path for path in defining if is_run(path)]
        return sorted(named, key=lambda p: (p.count("/"), p not in self._lab.files, p.endswith(".ipynb"), p))

    def _why_missing(self, name: str, home: str) -> Missing:
        """Return the `Missing` for a name that no file defines: a statement failed, a syntax error, no file `home`, not in it."""
        there = [home] if home in self.paths else []
        places = (*there, *self._other_files_defining(name, home))
        for path in places:
            for each in self.load(path).stepped_over:
                if name in each.defines:
                    why = f"{each.where} did not define {name}: {each.why}"
                    return Missing(name, fault_of_statement(each), why, each.at)
        for path in places:
            if (error := self.load(path).unreadable) is not None:
                return _invalid_file(name, error, path)
        if not there:
            return Missing(name, "file-missing", f"{home} was not handed in, and no other file defines {name}")
        return Missing(name, "name-missing", f"{home} does not define {name}")

    def note(self, text: str, hidden: GraderText | None = None) -> None:
        """Add a note to the report, unless it is there already.

        When hidden scenarios are graded, `hidden`, if given, replaces `text`, and only a `GraderText` (a constant of the grader's
        code) is added. Other text is dropped, as it may hold hidden data; the grader then loads the submission again with public
        data (`PublicSession`) and adds the notes on loading that this yields.
        """
        said = hidden or text
        if self.secret and not isinstance(said, GraderText):
            self.withheld_note = True
            return
        shown = printable(said if self.secret else text, _LONGEST_NOTE)
        if shown not in self.notes:
            self.notes.append(shown)


def _invalid_file(name: str, error: StudentError, path: str) -> Missing:
    """Return the `Missing` for a required name whose file is not valid Python."""
    said = f"{error.type}: {printable(error.message, 200)} at {error.where or path}"
    return Missing(name, "does-not-import", "\n".join([said, *error.lines]), error.at or Where(path))


def _strays_note(path: str, strays: Mapping[str, str]) -> str:
    """Return the note about required names that were found in the file `path`; `strays` has the file where each is expected."""
    names, homes = enumerated(strays), enumerated(dict.fromkeys(strays.values()))
    were, them = ("were", "them") if len(strays) > 1 else ("was", "it")
    return printable(
        f"{names} {were} found in {printable(path, 80)}; the sheet expects {them} in {homes}", _LONGEST_NOTE
    )


def is_run(path: str) -> bool:
    """Return whether the grader may run a file, by its name: not ``test_*``, ``conftest``, ``setup`` or others for tools."""
    return PurePosixPath(path).stem not in _NEVER_IMPORTED and not PurePosixPath(path).name.startswith("test_")
