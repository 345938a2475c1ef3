"""What a browser asks, read within bounds: fields of a form, a number, who is asking."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import parse_qsl, quote, unquote

from starlette.requests import Request

from grader.ground.errors import RequestError
from grader.ground.text import printable

MOST_BYTES = 2_000_000
_MOST_FIELDS = 5000  # a decision on a class of two thousand has one for each
_NAME = 80


class TooLargeError(Exception):
    """A form of more bytes than any of ours has."""


@dataclass(frozen=True)
class Ask:
    """One request.

    Attributes
    ----------
    author
        Who is asking.
    form
        The fields that were sent, each with all its values; empty with GET.
    query
        Those of the address.
    path
        Parts of the address that stand for something.
    """

    author: str
    form: Mapping[str, list[str]] = field(default_factory=dict)
    query: Mapping[str, list[str]] = field(default_factory=dict)
    path: Mapping[str, str] = field(default_factory=dict)

    def text(self, name: str) -> str:
        return (self.form.get(name) or self.query.get(name) or [""])[0].strip()

    def number(self, name: str) -> int | None:
        """A whole number, or None."""
        text = self.text(name)
        return int(text) if text.isascii() and text.isdigit() and len(text) < 16 else None

    def all(self, name: str) -> list[str]:
        return self.form.get(name, [])


async def read(request: Request, cookie: str, author: str) -> Ask:
    """The request as a handler wants it.

    Raises
    ------
    TooLargeError
        Before more is read than a form may have.
    RequestError
        If it has more fields.
    """
    data = bytearray()
    if request.method == "POST":
        async for piece in request.stream():
            data += piece
            if len(data) > MOST_BYTES:
                raise TooLargeError
    said = unquote(request.cookies.get(cookie, ""))
    fields = (_fields(data.decode("utf-8", "replace")), _fields(request.url.query))
    return Ask(name(said) or author, *fields, request.path_params)


def name(text: str) -> str:
    """How somebody may be called."""
    return printable(text.strip(), _NAME)


def in_cookie(text: str) -> str:
    return quote(text, safe="")


def _fields(text: str) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    try:
        for key, value in parse_qsl(text, keep_blank_values=True, max_num_fields=_MOST_FIELDS):
            found.setdefault(key, []).append(value)
    except ValueError as error:
        raise RequestError(f"the form has more than {_MOST_FIELDS} fields") from error
    return found
