"""Commands in the documents: each line of a code block, and each code span, that starts a program."""

from __future__ import annotations

import functools
import re
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from docs import generated
from grader import cli
from grader.kit import give, wheel

ROOT = Path(__file__).resolve().parent.parent
_PROGRAMS = r"(?:imugrade|pytest|python3?|pip|dask|bash|\.venv/bin/[a-z]+)"
_COMMAND = re.compile(rf"(?:[A-Z_]+=\S+ )*(?<!-){_PROGRAMS} \S.*")
_PIECE = re.compile(r"^ *```\w*\n(?P<fence>(?:.*\n)*?) *```$|^ {4}(?P<line>.*)$|`(?P<span>[^`]+)`", re.MULTILINE)
_SAID_OF_IT = re.compile(r"\s{2,}.*|\s#.*")  # a comment, or words in a column of their own


@dataclass(frozen=True)
class Command:
    """One command as a document has it: in a "block", in "prose" or in a "heading", with the variables that stand before it."""

    document: str
    words: tuple[str, ...]
    environment: tuple[tuple[str, str], ...] = ()
    place: str = "block"

    def __str__(self) -> str:
        return " ".join([*(f"{name}={value}" for name, value in self.environment), shlex.join(self.words)])


@functools.cache
def site() -> Mapping[str, str]:
    """Return the pages of the documentation by path."""
    return {path.as_posix(): text for path, text in generated.pages().items()}


def documents() -> dict[str, str]:
    """Return the texts for people who run commands, by name."""
    groups = cli.command().commands
    return {
        **{name: (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")},
        "the students' README.md": (Path(give.__file__).parent.parent / "labs" / "imu" / "starter" / "README.md.txt")
        .read_text(encoding="utf-8")
        .replace("{wheel}", wheel.name()),
        **{f"docs/{path}": text for path, text in site().items()},
        "imugrade traces --help": f"```text\n{groups['traces'].help}\n```\n",
    }


def commands(texts: Mapping[str, str]) -> Iterator[Command]:
    """Every command once for each document, in order."""
    for document, text in texts.items():
        seen = set()
        for command in _found(document, text):
            if command not in seen:
                seen.add(command)
                yield command


def _found(document: str, text: str) -> Iterator[Command]:
    for piece in _PIECE.finditer(text):
        if piece["span"] is not None:
            said = " ".join(piece["span"].split())
            if _COMMAND.fullmatch(said):
                yield from _parts(document, said, "heading" if _in_heading(text, piece.start()) else "prose")
        else:
            for line in (piece["fence"] or piece["line"]).splitlines():
                if hit := _COMMAND.search(line):
                    yield from _parts(document, _SAID_OF_IT.sub("", hit[0]), "block")


def _in_heading(text: str, at: int) -> bool:
    return text.startswith("#", text.rfind("\n", 0, at) + 1)


def _parts(document: str, line: str, place: str) -> Iterator[Command]:
    for part in line.split(" && "):
        words = shlex.split(part)
        count = next(i for i, word in enumerate(words) if not re.fullmatch(r"[A-Z_]+=.*", word))
        environment = tuple((name, value) for name, _, value in (word.partition("=") for word in words[:count]))
        yield Command(document, tuple(words[count:]), environment, place)
