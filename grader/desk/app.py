"""Routes of the review desk: which function answers which address. Every route that changes something is a POST."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import RedirectResponse, Response
from starlette.routing import Route

from grader.base.errors import RequestError
from grader.course.record.decisions import OvertakenError
from grader.desk import (
    calibrate,
    comparing,
    drafts,
    exports,
    grouping,
    overviews,
    regrade_requests,
    rubric_what_if,
    submissions,
    web_requests,
)
from grader.desk.auth import AccessControl, Keys
from grader.desk.classbook import Classbook
from grader.desk.rendering import STATIC, page
from grader.desk.web_requests import WebRequest

_A_MOMENT_S = 0.8
_ACTS = ("override", "repair", "take-back")  # sent to an address below their page; other forms are sent to their page
Handler = Callable[[Classbook, WebRequest], Response]

PAGES: dict[str, Handler] = {
    "/": overviews.review_queue,
    "/calibrate": calibrate.show,
    "/class": overviews.class_page,
    "/export": exports.show,
    "/find": overviews.find,
    "/groups": grouping.show_all,
    "/groups/{kind}/{key}": grouping.show,
    "/similar": comparing.show_all,
    "/similar/{first}/{second}": comparing.show,
    "/regrade-requests": regrade_requests.show,
    "/what-if": rubric_what_if.show,
    "/submission/{id}": submissions.show,
    "/submission/{id}/picture/{place:int}": submissions.picture,
}
WRITES: dict[str, Handler] = {
    "/calibrate": calibrate.save,
    "/draft": drafts.keep,
    "/export": exports.send,
    "/reviewed": overviews.mark_reviewed,
    "/groups/{kind}/{key}": grouping.decide,
    "/groups/take-back": grouping.take_back,
    "/regrade-requests": regrade_requests.add,
    "/what-if": rubric_what_if.save,
    "/submission/{id}/override": submissions.override,
    "/submission/{id}/repair": submissions.repair,
}


def application(book: Classbook, keys: Keys, author: str) -> AccessControl:
    """Return the review desk over one class, behind its access control, as an ASGI application.

    `keys`, an access token and a cookie, let a browser in. `author` is the default name under which decisions are stored.
    """
    called = f"{keys.cookie_name}-author"

    def endpoint(handler: Handler) -> Callable[[Request], Awaitable[Response]]:
        async def answer(request: Request) -> Response:
            try:
                web_request = await web_requests.read(request, called, author)
                await _wait_for_job(book, web_request, request)
                return await asyncio.get_running_loop().run_in_executor(
                    book.thread, _answer, handler, book, web_request
                )
            except web_requests.TooLargeError:
                return _error_page("The form is too large: at most 2 MB.", 413)
            except OvertakenError as problem:
                page_of_form, _, act = web_request.address.rpartition("/")
                back = page_of_form if act in _ACTS else web_request.address
                return _error_page(f"{problem}. Your change was not saved.", 409, back)
            except RequestError as problem:
                return _error_page(str(problem), 400)
            except Exception as problem:  # one failed page must not stop the desk
                return _error_page(f"The review desk failed: {type(problem).__name__}: {problem}", 500)

        return answer

    async def set_author(request: Request) -> Response:
        web_request = await web_requests.read(request, called, author)
        answer = RedirectResponse("/", 303)
        answer.set_cookie(
            called,
            web_requests.in_cookie(web_requests.name(web_request.text("name"))),
            httponly=True,
            samesite="strict",
        )
        return answer

    routes = [
        *(Route(path, endpoint(handler), methods=["GET"]) for path, handler in PAGES.items()),
        *(Route(path, endpoint(handler), methods=["POST"]) for path, handler in WRITES.items()),
        Route("/who", set_author, methods=["POST"]),
        *(Route(f"/static/{name}", _static(name), methods=["GET"]) for name in STATIC),
    ]
    nothing = {404: lambda request, problem: _error_page("This page does not exist.", 404)}
    return AccessControl(Starlette(routes=routes, exception_handlers=nothing), keys)


def _answer(handler: Handler, book: Classbook, web_request: WebRequest) -> Response:
    """Answer a request by its handler. A redirect means that a form was accepted, so its draft is dropped."""
    answer = handler(book, web_request)
    if web_request.form and answer.status_code == 303:
        drafts.drop(book, web_request)
    return answer


async def _wait_for_job(book: Classbook, web_request: WebRequest, request: Request) -> None:
    """Wait a moment for the grading job that a page shows, as most end within it; before an export, until all reports are there."""
    loop = asyncio.get_running_loop()
    job = book.jobs.get(web_request.number("job"))
    if job is not None and not job.done:
        await loop.run_in_executor(None, job.ended.wait, _A_MOMENT_S)
    if request.method == "POST" and request.url.path == "/export":
        await loop.run_in_executor(None, book.settled)


def _error_page(message: str, status: int, overtaken: str = "") -> Response:
    """Return the page of an error; `overtaken` is the page that somebody else has changed, to reload, "" for other errors."""
    return page("refused.html.j2", status, message=message, overtaken=overtaken)


def _static(name: str) -> Callable[[Request], Awaitable[Response]]:
    path, kind = STATIC[name]

    async def answer(request: Request) -> Response:
        return Response(path.read_bytes(), media_type=kind)

    return answer
