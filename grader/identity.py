"""Whom a row of a table means: by number, by e-mail address, or else by a name that no two people share."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping

from grader.standing import Person

_PARTICIPANT = re.compile(r"\D*?(\d+)")
_NO_WORD = re.compile(r"[\W_]+")


class Directory:
    """People of the submissions of a class, by all that they are called."""

    def __init__(self, people: Mapping[str, Iterable[Person]]) -> None:
        """`people` has those of each submission by its id, which is a name of theirs as well."""
        self._by: dict[str, defaultdict[str, set[str]]] = {k: defaultdict(set) for k in ("number", "email", "name")}
        for id_, members in people.items():
            self._by["number"][id_.casefold()].add(id_)
            for person in members:
                for number in filter(None, (person.key, person.sid)):
                    self._by["number"][number.casefold()].add(id_)
                self._by["email"][person.email.casefold()].add(id_)
                for spelling in spellings(person.name):
                    self._by["name"][spelling].add(id_)

    def find(self, numbers: Iterable[str], email: str = "", name: str = "") -> str | None:
        """The one submission that a row means; None if it means none, or cannot be told apart.

        A number goes before an address, an address before a name. A platform's own number that is not known ends the search only
        if the others find nothing either.
        """
        keys = [("number", number.strip().casefold()) for number in numbers]
        keys += [("email", email.strip().casefold()), *(("name", spelling) for spelling in spellings(name))]
        for kind, key in keys:
            ids = self._by[kind].get(key, set()) if key else set()
            if len(ids) == 1:
                return next(iter(ids))
        return None


def participant(cell: str) -> str:
    """The number in Moodle's `Participant 1234`, whatever the word is in the site's language."""
    found = _PARTICIPANT.fullmatch(cell.strip())
    return found[1] if found else cell.strip()


def spellings(name: str) -> set[str]:
    """A name without spaces and signs, from each of its words on: ``Doe, Jane`` and Canvas's ``doejane`` are ``Jane Doe``."""
    words = [word for word in _NO_WORD.split(name.casefold()) if word]
    return {"".join((*words[i:], *words[:i])) for i in range(len(words))}
