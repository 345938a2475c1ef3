"""Read YAML nodes as values and collect the problems with their lines, for a file that an instructor edits by hand.

Nodes have line numbers, keep duplicate keys apart and build no objects. One run reports all problems that were collected.
"""

from __future__ import annotations

import contextlib
import difflib
import math
import re
from collections.abc import Iterable, Sequence
from datetime import datetime, tzinfo
from typing import Any, NoReturn

import yaml

from grader.base.errors import RequestError
from grader.base.stamps import read_stamp
from grader.base.text import printable

MAX_BYTES = 1_000_000
MAX_EVENTS = 20_000  # the shipped file has about 300; PyYAML reads some 50,000 a second
MAX_DEPTH = 10  # the shipped file has 4 levels; PyYAML's composer recurses
MAX_SHOWN = 50  # problems reported at once; the rest are counted
LARGEST = 1000.0  # largest weight, points and seconds of a call

_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")

EARLIER = {"mistakes": "faults", "extensions": "due_dates"}
"""Names that rubric keys had in earlier versions, whose rubrics the records of classes hold."""


class RubricError(RequestError):
    """The rubric cannot be used. The message has one line per problem: ``rubric.yaml:LINE: what is wrong; what to do``."""


def refuse(source: str, problems: Iterable[tuple[int, str]]) -> NoReturn:
    lines = [f"{source}:{line}: {problem}" for line, problem in sorted(problems, key=lambda p: p[0])]
    if len(lines) > MAX_SHOWN:
        lines[MAX_SHOWN:] = [f"{source}: and {len(lines) - MAX_SHOWN} more problems; correct these first"]
    raise RubricError("\n".join(lines))


def nearest(word: str, known: Iterable[str]) -> str:
    """Return the known word with the most similar spelling, to suggest it in a message; "" if none is similar."""
    return next(iter(difflib.get_close_matches(word[:100], list(known), n=1)), "")


def did_you_mean(word: str, known: Iterable[str], otherwise: str) -> str:
    """Return the end of an error message: "did you mean …?" with the most similar known word, or `otherwise` if none is similar."""
    guess = nearest(word, known)
    return f"did you mean {guess}?" if guess else otherwise


def guess_at(word: str, known: Iterable[str]) -> str:
    """Return an addition to an error message: " (did you mean …?)" with the most similar known word; "" if none is similar."""
    guess = nearest(word, known)
    return f" (did you mean {guess}?)" if guess else ""


def quote(node: yaml.Node) -> str:
    """Return a YAML node for a message: its text in quotation marks, or ``a list or a mapping``."""
    return f"'{printable(node.value, 60)}'" if isinstance(node, yaml.ScalarNode) else "a list or a mapping"


class NodeReader:
    """Reads YAML nodes of a rubric as values. It collects problems in place of raising, so that one run reports all of them.

    In its methods, None as a node stands for a key that the file lacks: the value is then empty, and no problem is added. `what`
    names the node in the text of a problem.
    """

    def __init__(self, source: str) -> None:
        self.source = source
        self.problems: list[tuple[int, str]] = []

    def stop_on_problems(self) -> None:
        if self.problems:
            refuse(self.source, self.problems)

    def say(self, node: yaml.Node, problem: str) -> None:
        self.problems.append((node.start_mark.line + 1, problem))

    def compose(self, data: bytes) -> yaml.Node:
        """Parse a rubric's bytes, return the root node; raise RubricError if empty, too large or deep, no YAML, or with anchors."""
        if len(data) > MAX_BYTES:
            refuse(self.source, [(1, "the file is larger than 1 MB; start again from the shipped rubric.yaml")])
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            refuse(self.source, [(data[: error.start].count(b"\n") + 1, "this is not UTF-8; save the file as UTF-8")])
        try:
            root = self._tree_of(text)
        except yaml.MarkedYAMLError as error:
            refuse(self.source, [_syntax_problem(error)])
        except yaml.reader.ReaderError as error:
            line = text[: error.position].count("\n") + 1
            refuse(self.source, [(line, f"the character U+{ord(text[error.position]):04X} is not text; remove it")])
        except (ValueError, OverflowError):  # PyYAML's own: "\UFFFFFFFF", %YAML with thousands of digits
            refuse(self.source, [(1, "the file is not YAML; start again from the shipped rubric.yaml")])
        if root is None:
            refuse(self.source, [(1, "the file is empty; start again from the shipped rubric.yaml")])
        return root

    def _tree_of(self, text: str) -> yaml.Node | None:
        """Parse with PyYAML's C parser, which is ten times as fast; if it fails, with the Python one, whose errors say more."""
        with contextlib.suppress(yaml.YAMLError, ValueError, OverflowError):
            return self._composed(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        return self._composed(text, yaml.SafeLoader)

    def _composed(self, text: str, loader: Any) -> yaml.Node | None:
        self._survey(text, loader)
        root: yaml.Node | None = yaml.compose(text, Loader=loader)
        return root

    def _survey(self, text: str, loader: Any) -> None:
        """Refuse files that would exhaust the parser's time or stack: aliases, deep nesting, too many nodes."""
        depth = 0
        for count, event in enumerate(yaml.parse(text, Loader=loader)):
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            line = event.start_mark.line + 1 if event.start_mark else 1
            if isinstance(event, yaml.NodeEvent) and event.anchor is not None:
                refuse(self.source, [(line, "anchors and aliases (& and *) are not read; write the value out")])
            if depth > MAX_DEPTH:
                refuse(self.source, [(line, "this is nested too deeply; see the shipped rubric.yaml for the layout")])
            if count > MAX_EVENTS:
                refuse(self.source, [(line, "the file says far too much; start again from the shipped rubric.yaml")])

    def fields(
        self, node: yaml.Node | None, what: str, required: Sequence[str], optional: Sequence[str] = ()
    ) -> dict[str, yaml.Node]:
        """Return a mapping's value nodes by key; add a problem for each missing or unknown key. {} if the node is no mapping.

        `what` names the mapping in problems. A name that a key had in earlier versions counts as its current name, as records of
        classes hold old rubrics; if the mapping has both, the earlier name is an unknown key.
        """
        if node is None:
            return {}
        if not isinstance(node, yaml.MappingNode):
            self.say(node, f"{what} must be `key: value` lines with the keys {', '.join((*required, *optional))}")
            return {}
        keys = (*required, *optional)
        written = self.pairs(node, what)
        given = {
            now if (now := EARLIER.get(name, name)) in keys and now not in written else name: pair
            for name, pair in written.items()
        }
        meant = {nearest(name, keys) for name in given}  # a misspelt key is not reported as missing as well
        for name, (key, _) in given.items():
            if name not in keys:
                self.say(key, f"unknown key {quote(key)} in {what}{guess_at(name, keys)}; correct or remove it")
        for name in required:
            if name not in meant:
                self.say(node, f"{what} has no key `{name}`; add it")
        return {name: value for name, (_, value) in given.items() if name in keys}

    def pairs(self, node: yaml.MappingNode, what: str) -> dict[str, tuple[yaml.Node, yaml.Node]]:
        """Return (key node, value node) by the key's text; add a problem for a key that is a list or appears twice.

        `what` names the mapping in problems.
        """
        found: dict[str, tuple[yaml.Node, yaml.Node]] = {}
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                self.say(key, f"a key of {what} must be a word, not a list or a mapping; correct it")
            elif key.value in found:
                first = found[key.value][0].start_mark.line + 1
                self.say(key, f"{quote(key)} appears twice in {what} (first on line {first}); remove one")
            else:
                found[key.value] = (key, value)
        return found

    def text(self, node: yaml.Node | None, what: str, pattern: re.Pattern[str] | None = None, like: str = "") -> str:
        """Return a node's line of text; "" for None or after adding a problem, such as that `pattern` does not match all of it.

        That problem reads "`what` must be `like`, not …": `what` names the node, `like` says what `pattern` matches.
        """
        if node is None:
            return ""
        if not isinstance(node, yaml.ScalarNode) or node.tag != "tag:yaml.org,2002:str" or not node.value.strip():
            self.say(node, f"{what} must be text, not {quote(node)}; write it in quotes")
        elif printable(node.value, 200) != node.value:
            self.say(node, f"{what} must be one line of at most 200 printable characters; shorten it")
        elif pattern is not None and not pattern.fullmatch(node.value):
            self.say(node, f"{what} must be {like}, not {quote(node)}; correct it")
        else:
            return str(node.value)
        return ""

    def number(self, node: yaml.Node | None, what: str, low: float = 0.0, high: float = LARGEST) -> float | None:
        """Return a node's number; None for None or after adding the problem "`what` must be a number from `low` to `high`"."""
        if node is None:
            return None
        plain = isinstance(node, yaml.ScalarNode) and not node.style and _NUMBER.fullmatch(node.value)
        value = float(node.value) if plain else math.nan
        if low <= value <= high:
            return value
        self.say(node, f"{what} must be a number from {low:g} to {high:g}, not {quote(node)}; correct it")
        return None

    def points(self, node: yaml.Node | None, what: str) -> float | None:
        """Return a node's points; None for None or after adding a problem about `what`. A third decimal is a problem, but kept."""
        value = self.number(node, what)
        if node is not None and value is not None and round(value, 2) != value:
            self.say(node, f"{what} must have at most two decimals, not {quote(node)}; round it")
        return value

    def share(self, node: yaml.Node | None, what: str, of: float) -> float | None:
        """Return points, from a number or a percentage of `of` points; None for None or after adding a problem about `what`."""
        if isinstance(node, yaml.ScalarNode) and node.value.endswith("%"):
            number = node.value[:-1].strip()
            if _NUMBER.fullmatch(number) and 0 <= float(number) <= 100:
                return round(of * float(number) / 100, 2)
            self.say(node, f"{what} must be a number of points or a percentage from 0 % to 100 %, not {quote(node)}")
            return None
        return self.points(node, what)

    def stamp(self, node: yaml.Node | None, what: str, zone: tzinfo | None = None) -> datetime | None:
        """Return a date and time in UTC; None for None or after adding a problem about `what`, the node's name in messages.

        `zone` is the time zone of a text without an offset from UTC; if `zone` is None, such a text adds a problem.
        """
        when = read_stamp(node.value, zone) if isinstance(node, yaml.ScalarNode) else None
        if node is not None and when is None:
            example = "2026-11-20T23:59+01:00"
            self.say(
                node, f"{what} must be a date and time with its offset from UTC, like {example}, not {quote(node)}"
            )
        return when

    def records(
        self, node: yaml.Node | None, what: str, known: Sequence[str], required: Sequence[str], optional: Sequence[str]
    ) -> dict[str, tuple[yaml.Node, dict[str, yaml.Node]]]:
        """Return, by the id of each item of a list, its node and the value nodes of its keys, in the order of `known` ids.

        Unknown, missing and repeated ids add problems, and so does an item with other keys than `required` and `optional`. They
        call an item `what`, such as "criterion".
        """
        if node is None:
            return {}
        if not isinstance(node, yaml.SequenceNode):
            self.say(node, f"this must be a list with one `- id: …` for each {what}; see the shipped rubric.yaml")
            return {}
        found: dict[str, tuple[yaml.Node, dict[str, yaml.Node]]] = {}
        for item in node.value:
            fields = self.fields(item, f"this {what}", required, optional)
            name = self._known_id(fields.get("id"), what, known)
            if name in found:
                first = found[name][0].start_mark.line + 1
                self.say(item, f"the {what} {name} appears twice (first on line {first}); remove one")
            elif name:
                found[name] = (item, fields)
        for name in known:
            if name not in found:
                self.say(node, f"the {what} {name} is missing; add it")
        return {name: found[name] for name in known if name in found}

    def _known_id(self, node: yaml.Node | None, what: str, known: Sequence[str]) -> str:
        """Return the id in a node; for a misspelt one add a problem and return the nearest, so that it is not missed as well."""
        name = self.text(node, "an id")
        if node is None or not name or name in known:
            return name
        self.say(node, f"unknown {what} {quote(node)}{guess_at(name, known)}; the ids are {', '.join(known)}")
        return nearest(name, known)


def _syntax_problem(error: yaml.MarkedYAMLError) -> tuple[int, str]:
    mark = error.problem_mark or error.context_mark
    what = printable(", ".join(filter(None, (error.context, error.problem))) or "this is not YAML", 150)
    return (mark.line + 1 if mark else 1), f"YAML cannot be read here: {what}; correct the line or the one before"
