"""Requests to the desk, parsed with bounds on size and number of fields: form fields, numbers, the author."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import parse_qsl, quote, unquote

from starlette.requests import Request

from grader.base.errors import RequestError
from grader.base.text import printable

MOST_BYTES = 2_000_000
_MOST_FIELDS = 5000  # a decision for a class of 2000 has one field per submission
_NAME = 80


class TooLargeError(Exception):
    """Exception: the body of a request is larger than any form of the desk, so that it is not read to the end."""


@dataclass(frozen=True)
class WebRequest:
    """One HTTP request to the desk with its fields read, as every handler gets it.

    Attributes
    ----------
    author
        The name under which a decision is stored.
    form
        The form fields, each with all its values; empty for GET.
    query
        The query parameters.
    path
        The parameters of the route, such as the ``id`` in ``/submission/{id}``.
    address
        The path of the URL, such as ``/submission/alice``.
    """

    author: str
    form: Mapping[str, list[str]] = field(default_factory=dict)
    query: Mapping[str, list[str]] = field(default_factory=dict)
    path: Mapping[str, str] = field(default_factory=dict)
    address: str = ""

    def text(self, name: str) -> str:
        return (self.form.get(name) or self.query.get(name) or [""])[0].strip()

    def number(self, name: str) -> int | None:
        """Return a form or query field as a whole number from 0; None if it is missing or holds anything else."""
        text = self.text(name)
        return int(text) if text.isascii() and text.isdigit() and len(text) < 16 else None

    def all(self, name: str) -> list[str]:
        return self.form.get(name, [])


async def read(request: Request, cookie: str, author: str) -> WebRequest:
    """Read the fields of a request within bounds; its author is the name in the cookie called `cookie`, `author` if it has none.

    Raises
    ------
    TooLargeError
        If the body is larger than `MOST_BYTES`.
    RequestError
        If the form or the query has more than `_MOST_FIELDS` fields.
    """
    data = bytearray()
    if request.method == "POST":
        async for piece in request.stream():
            data += piece
            if len(data) > MOST_BYTES:
                raise TooLargeError
    said = unquote(request.cookies.get(cookie, ""))
    fields = (_fields(data.decode("utf-8", "replace")), _fields(request.url.query))
    return WebRequest(name(said) or author, *fields, request.path_params, request.url.path)


def name(text: str) -> str:
    """Return a typed name, under which decisions are stored, without control characters; "" if it is blank."""
    return printable(text.strip(), _NAME)


def in_cookie(text: str) -> str:
    return quote(text, safe="")


def _fields(text: str) -> dict[str, list[str]]:
    """Parse form fields into all values of each name; RequestError for more than `_MOST_FIELDS`, to bound the work."""
    found: dict[str, list[str]] = {}
    try:
        for key, value in parse_qsl(text, keep_blank_values=True, max_num_fields=_MOST_FIELDS):
            found.setdefault(key, []).append(value)
    except ValueError as error:
        raise RequestError(f"the form has more than {_MOST_FIELDS} fields") from error
    return found
