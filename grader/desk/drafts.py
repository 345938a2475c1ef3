"""Drafts: what a person types into a form is stored until the form is sent, so that a reload loses nothing."""

from __future__ import annotations

import json
from collections.abc import Mapping
from urllib.parse import unquote

from starlette.responses import Response

from grader.base.errors import RequestError
from grader.desk.classbook import Classbook
from grader.desk.rendering import address
from grader.desk.web_requests import WebRequest
from grader.report import words

Fields = list[list[str]]


def keep(book: Classbook, web_request: WebRequest) -> Response:
    """Store as a draft a form's fields, which the page's script sends as JSON pairs of name and value; an empty list deletes it."""
    form, text = web_request.text("draft"), web_request.text("fields")
    if not _fields(text):
        book.store.drop_draft(web_request.author, form)
    else:
        book.store.keep_draft(web_request.author, form, text)
    return Response(status_code=204)


def drop(book: Classbook, web_request: WebRequest) -> None:
    """Delete the draft of a form that was sent; do nothing if the form names no draft."""
    if form := web_request.text("draft"):
        book.store.drop_draft(web_request.author, form)


def of_page(book: Classbook, web_request: WebRequest) -> Mapping[str, Fields]:
    """Return the stored drafts of a page by name of form, to fill the forms again. A name begins with the address of the page."""
    kept = book.store.drafts(web_request.author)
    return {form: _fields(text) for form, text in kept.items() if _path(_address(form)) == web_request.address}


def unsaved(book: Classbook, web_request: WebRequest) -> dict[str, str]:
    """Return address and title of each page where text was typed and not sent, to list them on the first page.

    The title is the student's name; on a page about no submission, the path.
    """
    people = {address(each): words.distinct(each) for each in book.final_grades().values()}
    pages = map(_address, book.store.drafts(web_request.author))
    return {page: people.get(page.partition("?")[0], _path(page).strip("/")) for page in pages}


def _address(form: str) -> str:
    return form.partition("#")[0]


def _path(page: str) -> str:
    return unquote(page.partition("?")[0])


def _fields(text: str) -> Fields:
    try:
        pairs = json.loads(text or "[]")
    except (ValueError, RecursionError):
        pairs = None
    if not isinstance(pairs, list) or not all(
        isinstance(pair, list) and len(pair) == 2 and all(isinstance(each, str) for each in pair) for pair in pairs
    ):
        raise RequestError("The draft is no list of fields")
    return pairs
