"""What came of filling a platform's own file: its bytes, and who was left out of it and why."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from grader.ground.errors import RequestError
from grader.ground.text import printable
from grader.people.identity import Directory, Match
from grader.people.identity import Row as Who
from grader.people.standing import Standing
from grader.report import words


@dataclass
class Filled:
    """The filled file, how many grades went in, and lines on what did not."""

    data: bytes = b""
    grades: int = 0
    placed: set[str] = field(default_factory=set)
    blank: list[str] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)

    def left_out(self, standings: Mapping[str, Standing]) -> Iterator[str]:
        """Who has a result and no row, who has a row and no result, and rows that were left as they are."""
        missing = [id_ for id_ in standings if id_ not in self.placed]
        still_open = [id_ for id_ in self.placed if standings[id_].final is None]
        yield from _line("graded, and not in the file", missing)
        yield from _line("in the file, and not graded (left as it is)", self.blank)
        yield from _line("not judged, through a fault of the grader (left as it is)", sorted(still_open))
        yield from _line("not to be changed in the file (left as it is)", self.kept)


def _line(what: str, names: list[str]) -> Iterator[str]:
    for start in range(0, len(names), 20):
        yield f"{what}: {', '.join(printable(name, 80) for name in names[start : start + 20])}"


def directory(standings: Mapping[str, Standing]) -> Directory:
    return Directory({id_: standing.people for id_, standing in standings.items()})


def matched(rows: Iterable[tuple[int, Who]], known: Directory) -> dict[int, Match | None]:
    """Whose each row is, by its number. Two rows that mean one and the same person are both given to nobody."""
    found = {number: known.find(who) for number, who in rows}
    owners: dict[Match, list[int]] = {}
    for number, match in found.items():
        if match is not None and match.person is not None:
            owners.setdefault(match, []).append(number)
    twice = {number for numbers in owners.values() if len(numbers) > 1 for number in numbers}
    return {number: None if number in twice else match for number, match in found.items()}


def refuse_other_scale(source: str, cell: str, standings: Mapping[str, Standing]) -> None:
    """A mark out of 100 in a column out of 10 would be a wrong mark for everyone."""
    try:
        most = float(cell.replace(",", "."))
    except ValueError:
        return  # no number there: the platform knows
    for standing in standings.values():
        if standing.result.max_score != most:
            raise RequestError(
                f"{source}: the assignment is out of {words.number(most)}, and the rubric out of "
                f"{words.number(standing.result.max_score)}; make them equal on the platform or in rubric.yaml"
            )
