"""A platform's own file, filled in: grades go into one column, and who was left out, and what was replaced, is told."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from grader.ground.errors import RequestError
from grader.ground.text import printable
from grader.people.identity import Directory, Match
from grader.people.identity import Row as Who
from grader.people.standing import Standing
from grader.platforms.sheet import Row, Sheet
from grader.report import words

_COMMA = re.compile(r"-?\d+,\d+")


@dataclass
class Filled:
    """The filled file, how many grades went in, and lines on what did not."""

    data: bytes = b""
    grades: int = 0
    placed: set[str] = field(default_factory=set)
    blank: list[str] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    replaced: list[str] = field(default_factory=list)

    def left_out(self, standings: Mapping[str, Standing]) -> Iterator[str]:
        """Who has a result and no row, who has a row and no result, rows that were left as they are, and grades that were not."""
        missing = [id_ for id_ in standings if id_ not in self.placed]
        still_open = [id_ for id_ in self.placed if standings[id_].final is None and not standings[id_].unseen]
        yield from _line("graded, and not in the file", missing)
        yield from _line("in the file, and not graded (left as it is)", self.blank)
        yield from _line("not judged, through a fault of the grader (left as it is)", sorted(still_open))
        yield from _line("not to be changed in the file (left as it is)", self.kept)
        yield from _line("had another grade in the file, which was replaced", self.replaced)


@dataclass(frozen=True)
class Form:
    """A platform's file as it is to be filled.

    Attributes
    ----------
    source
        What messages call it.
    grade
        The column of the grades.
    rows
        Those of people, by their number.
    who, name
        Whom a row means, and what lines call them.
    out_of
        What the grade is out of, as the file says it; "" where it does not.
    locked
        Whether the grade is not to be changed.
    """

    source: str
    sheet: Sheet
    grade: int
    rows: Mapping[int, Row]
    who: Callable[[Row], Who]
    name: Callable[[Row], str]
    out_of: Callable[[Row], str]
    locked: Callable[[Row], bool]

    def matches(self, standings: Mapping[str, Standing]) -> dict[int, Match | None]:
        return matched(((number, self.who(row)) for number, row in self.rows.items()), directory(standings))


def fill_in(
    form: Form, matches: Mapping[int, Match | None], standings: Mapping[str, Standing], *, scaled: bool
) -> Filled:
    """Set the final points of everyone who has some.

    Parameters
    ----------
    form
        The file; its sheet is changed.
    matches
        Whose each row is.
    standings
        By id of the submission.
    scaled
        Whether points are scaled where the file is out of others than the rubric.

    Raises
    ------
    RequestError
        If it is out of other points, and they are not to be scaled.
    """
    filled = Filled()
    comma = any(_COMMA.fullmatch(text.strip()) for row in form.rows.values() for text in _numbers(form, row))
    for number, row in form.rows.items():
        match = matches[number]
        if match is None:
            filled.blank.append(form.name(row))
            continue
        standing = standings[match.id]
        filled.placed.add(standing.id)
        if form.locked(row):
            filled.kept.append(form.name(row))
        elif standing.final is not None:
            points = words.number(standing.final * _scale(form, row, standing, scaled=scaled))
            _set(form, row, points.replace(".", ",") if comma else points, filled)
    return filled


def _numbers(form: Form, row: Row) -> tuple[str, str]:
    return row.value(form.grade), form.out_of(row)


def _set(form: Form, row: Row, points: str, filled: Filled) -> None:
    before = row.value(form.grade).strip()
    known = _number(before)
    if before not in ("", "-") and (known is None or words.number(known) != points.replace(",", ".")):
        filled.replaced.append(f"{form.name(row)} ({before} → {points})")
    form.sheet.set(row, form.grade, points)
    filled.grades += 1


def _scale(form: Form, row: Row, standing: Standing, *, scaled: bool) -> float:
    """A mark out of 100 in a column out of 10 would be a wrong mark for everyone."""
    most, ours = _number(form.out_of(row)), standing.result.max_score
    if most is None or most == ours:
        return 1.0  # no number there: the platform knows
    if not scaled:
        raise RequestError(
            f"{form.source}: the assignment is out of {words.number(most)}, and the rubric out of {words.number(ours)}; "
            "add --scale to have the points scaled, or make them equal on the platform or in rubric.yaml"
        )
    return most / ours


def _number(cell: str) -> float | None:
    try:
        return float(cell.strip().replace(",", "."))
    except ValueError:
        return None


def _line(what: str, names: Sequence[str]) -> Iterator[str]:
    """Every name; they are parted by semicolons, as many are ``Last, First``."""
    for start in range(0, len(names), 20):
        yield f"{what}: {'; '.join(printable(name, 80) for name in names[start : start + 20])}"


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
