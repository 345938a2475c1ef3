"""Match rows of tables (roster, gradebook) with the people who handed in: by number, e-mail address or unambiguous name.

A doubtful row matches nobody. A contradiction, such as another number or address, keeps two people of one name apart.
`Directory.why_not` gives the reason.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.intake.names import folded
from grader.people.final_grade import Person

_PARTICIPANT = re.compile(r"\D*?(\d+)")
_NUMBERING = ("canvas", "moodle")  # their numbers are valid on the platform only
_SUREST_FIRST = (*_NUMBERING, "number", "email", "foreign", "name")
_A_FEW = 5
_NO_WORD = re.compile(r"[\W_]+")


@dataclass(frozen=True)
class PersonRow:
    """One person's row of a roster or gradebook, to be matched with a submission.

    Attributes
    ----------
    platform, key : the platform and its own number of the person; "" if the table has none
    numbers : ids of any kind: student numbers, logins, user names, ids of submissions
    """

    platform: str = ""
    key: str = ""
    numbers: tuple[str, ...] = ()
    email: str = ""
    name: str = ""

    def in_words(self) -> str:
        return self.name or self.email or next(filter(None, (*self.numbers, self.key)), "")


@dataclass(frozen=True)
class Match:
    """The submission, by id, and the person that a row of a table matches; `person` is None if the row means a whole group."""

    id: str
    person: Person | None


class Directory:
    """Index of the people of a class by every number, address and name, to match rows of rosters and gradebooks with them."""

    def __init__(self, people: Mapping[str, tuple[Person, ...]]) -> None:
        """Index the people of each submission, given by its id, which is also looked up as a number of theirs."""
        self._by: dict[tuple[str, str], list[Match]] = {}
        for id_, members in people.items():
            self._add("number", id_, Match(id_, members[0] if len(members) == 1 else None))
            for person in members:
                for kind, word in _called(person):
                    self._add(kind, word, Match(id_, person))

    def find(self, row: PersonRow) -> Match | None:
        """Return the submission and person that a table's row names; None if it fits nobody or more than one submission."""
        return self._best_match(row)[1]

    def find_each(self, rows: Sequence[PersonRow]) -> list[Match | None]:
        """Return the match of each row, None for a row without one.

        If rows match the same person, only the row with the surest kind of identifier keeps its match, if just one has it.
        A platform's own number is the surest; then come other numbers, e-mail address and name.
        """
        found = [self._best_match(row) for row in rows]
        claims: dict[Match, set[tuple[int, PersonRow]]] = {}
        for row, (sureness, match) in zip(rows, found, strict=True):
            if match is not None and match.person is not None:
                claims.setdefault(match, set()).add((sureness, row))
        return [
            None if match in claims and not _is_best_claim((sureness, row), claims[match]) else match
            for row, (sureness, match) in zip(rows, found, strict=True)
        ]

    def why_not(self, row: PersonRow) -> str:
        """Return for a warning why a row was left without a match; "" if nobody resembles the person in the row.

        It fits several submissions, or its identifiers contradict the person's. If it fits just one submission, the reason given is
        that another row means the same person: other rows are not looked at.
        """
        refused = ""
        for kind, word in _asked(row):
            known = self._by.get((kind, word.casefold()), ()) if word else ()
            contradictions = {match: _contradiction(row, match.person, kind) for match in known}
            possible = [match for match, contradiction in contradictions.items() if not contradiction]
            if len({match.id for match in possible}) > 1:
                return f"may mean {' or '.join(map(_match_in_words, possible[:_A_FEW]))}"
            if possible:
                return f"another row means {_match_in_words(possible[0])} as well"
            refused = refused or next((f"not {_match_in_words(m)}: {why}" for m, why in contradictions.items()), "")
        return refused

    def _best_match(self, row: PersonRow) -> tuple[int, Match | None]:
        """Return the rank of the kind of identifier that matched, lowest surest, and the match; the last rank and None if none."""
        for kind, word in _asked(row):
            matches = [
                m for m in self._by.get((kind, word.casefold()), ()) if word and not _contradiction(row, m.person, kind)
            ]
            if len({match.id for match in matches}) == 1:
                return _SUREST_FIRST.index(kind), matches[0]
        return len(_SUREST_FIRST), None

    def _add(self, kind: str, word: str, match: Match) -> None:
        known = self._by.setdefault((kind, word.casefold()), [])
        if word and match not in known:
            known.append(match)


class PersonLookup:
    """Finder of the submission that an instructor means by an id, a number, an e-mail address or a name."""

    def __init__(self, people: Mapping[str, tuple[Person, ...]]) -> None:
        self._ids, self._directory = people.keys(), Directory(people)

    def by(self, word: str) -> str:
        """Return the id of the submission that a word identifies; the word itself if it identifies no submission.

        Raises
        ------
        RequestError
            If the word fits several people, or several ids begin with it. The message names them.
        """
        if word in self._ids:
            return word
        asked = (PersonRow(numbers=(word,)), PersonRow(email=word), PersonRow(name=word))
        for row in asked:
            match = self._directory.find(row)
            if match is not None:
                return match.id
        several = [id_ for id_ in self._ids if folded(id_).startswith(folded(word))]
        begins = f"may mean {', '.join(several[:_A_FEW])}" if len(several) > 1 else ""
        ambiguous = next(filter(None, map(self._directory.why_not, asked)), begins)
        if ambiguous:
            raise RequestError(printable(f"{word} is ambiguous: it {ambiguous}; give the id", 1000))
        return word


def _is_best_claim(claim: tuple[int, PersonRow], claims: set[tuple[int, PersonRow]]) -> bool:
    return all(claim[0] < sureness or row == claim[1] for sureness, row in claims)


def _called(person: Person) -> Iterator[tuple[str, str]]:
    yield (person.platform if person.platform in _NUMBERING else "number"), person.key
    yield "foreign", person.key
    yield from (("number", number) for number in (person.sid, *person.ids))
    yield "email", person.email
    yield from (("name", spelling) for spelling in spellings(person.name))


def _asked(row: PersonRow) -> Iterator[tuple[str, str]]:
    """Yield kind and text of the words to look up, surest first. "foreign": a number that may be a platform's; names must agree."""
    yield row.platform, row.key.strip()
    yield from (("number", number.strip()) for number in row.numbers)
    yield "email", row.email.strip()
    yield from (("foreign", number.strip()) for number in row.numbers)
    yield from (("name", spelling) for spelling in spellings(row.name))


def _contradiction(row: PersonRow, person: Person | None, kind: str) -> str:
    """Return what speaks against a match of row and person by a word of this kind, such as other numbers; "" if nothing does."""
    if person is None:
        return ""
    if row.key and person.platform == row.platform and row.key.strip() != person.key:
        return f"{row.platform} number {row.key.strip()} and {person.key}"
    if kind == "foreign":
        other = bool(row.name and person.name) and not spellings(row.name) & spellings(person.name)
        return f"names {row.name} and {person.name}" if other else ""
    if kind != "name":
        return ""
    if row.email and person.email and row.email.strip().casefold() != person.email.casefold():
        return f"addresses {row.email.strip()} and {person.email}"
    theirs = tuple(filter(None, (person.sid, *person.ids)))
    if row.numbers and person.sid and not set(map(_digits, row.numbers)) & set(map(_digits, theirs)):
        return f"numbers {', '.join(row.numbers)} and {', '.join(theirs)}"
    return ""


def _digits(number: str) -> str:
    """Return the digits of a student number without leading zeros, so that `S5039` and `05039` are equal.

    An identifier without digits is returned in small letters.
    """
    return re.sub(r"\D", "", number).lstrip("0") or number.strip().casefold()


def _match_in_words(match: Match) -> str:
    person = match.person
    known = ", ".join(dict.fromkeys(filter(None, (person.name, person.sid or person.email)))) if person else ""
    return f"{match.id} ({known})" if known and known != match.id else match.id


def participant(cell: str) -> str:
    """Return the number in Moodle's `Participant 1234` (the word depends on the site's language); other text as it is."""
    found = _PARTICIPANT.fullmatch(cell.strip())
    return found[1] if found else cell.strip()


def spellings(name: str) -> set[str]:
    """Return the rotations of a name's words, joined without spaces and punctuation, so that ``Doe, Jane`` matches ``janedoe``."""
    words = [word for word in _NO_WORD.split(name.casefold()) if word]
    return {"".join((*words[i:], *words[:i])) for i in range(len(words))}
