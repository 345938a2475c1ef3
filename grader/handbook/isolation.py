"""The page of the isolation: what each rung promises, and what the attacks on it came to."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from grader.ground.package_data import beside
from grader.sandbox import packages, surroundings
from grader.sandbox.rungs import RUNGS, UNWALLED

Entry = Mapping[str, Any]


def page() -> str:
    """The text with the figures of `isolation.json`, which `python -m tests.hostile --write` makes."""
    entries: list[Entry] = json.loads(beside(__package__, "isolation.json").read_text(encoding="utf-8"))
    programs = {entry["family"]: entry["programs"] for entry in entries}
    text = beside(__package__, "isolation.txt").read_text(encoding="utf-8")
    return (
        text.replace("{rungs}", "\n".join(f"| `{rung.name}` | {rung.around} | {rung.needs} |" for rung in RUNGS))
        .replace("{programs}", str(sum(programs.values())))
        .replace("{libraries}", _listed(f"`{name}`" for name in packages.LIBRARIES))
        .replace("{system}", _listed(f"`{path}`" for path in surroundings.SYSTEM))
        .replace("{table}", "\n".join(_table(entries, programs)))
        .replace("{none}", "\n".join(_fallen([entry for entry in entries if entry["rung"] == UNWALLED.name])))
    )


def _listed(names: Iterable[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}"


def _table(entries: Sequence[Entry], programs: Mapping[str, int]) -> Iterator[str]:
    yield f"| Rung | As | {' | '.join(f'{family} ({count})' for family, count in programs.items())} |"
    yield "| --- | --- |" + " --- |" * len(programs)
    for rung, user in dict.fromkeys((entry["rung"], entry["user"]) for entry in entries):
        of = {entry["family"]: entry for entry in entries if (entry["rung"], entry["user"]) == (rung, user)}
        cells = (_cell(of[family]) if family in of else "not run" for family in programs)
        yield f"| `{rung}` | {user} | {' | '.join(cells)} |"


def _cell(entry: Entry) -> str:
    fell = len(entry["fell"])
    return f"{entry['programs'] - fell} held, {fell} fell"


def _fallen(entries: Sequence[Entry]) -> Iterator[str]:
    """Each attack that succeeds where nothing isolates, with what it did."""
    if not any(entry["fell"] for entry in entries):
        return
    yield "What falls on `none`, and what it does there; this is what the walls are for:\n"
    yield "| Family | Program | As | What happened |"
    yield "| --- | --- | --- | --- |"
    for entry in entries:
        for name, trouble in entry["fell"].items():
            yield f"| {entry['family']} | {name} | {entry['user']} | {trouble.replace('|', chr(92) + '|')} |"
