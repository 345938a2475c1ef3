"""The pages of the desk and what can be done on them: addresses to functions. Whatever changes something comes by POST."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import RedirectResponse, Response
from starlette.routing import Route

from grader.course.record import OvertakenError
from grader.desk import asking, comparing, grouping, overviews, regrade_requests, rubric_what_if, submissions
from grader.desk.asking import Ask
from grader.desk.auth import Doors, Keys
from grader.desk.classbook import Classbook
from grader.desk.rendering import STATIC, page
from grader.ground.errors import RequestError

Handler = Callable[[Classbook, Ask], Response]

PAGES: dict[str, Handler] = {
    "/": overviews.needs_a_look,
    "/class": overviews.everybody,
    "/groups": grouping.show_all,
    "/groups/{kind}/{key}": grouping.show,
    "/alike": comparing.show_all,
    "/alike/{first}/{second}": comparing.show,
    "/appeals": regrade_requests.show,
    "/cost": rubric_what_if.show,
    "/submission/{id}": submissions.show,
    "/submission/{id}/picture/{place:int}": submissions.picture,
}
WRITES: dict[str, Handler] = {
    "/tick": overviews.tick,
    "/groups/{kind}/{key}": grouping.decide,
    "/decisions/take-back": grouping.take_back,
    "/appeals": regrade_requests.add,
    "/cost": rubric_what_if.save,
    "/submission/{id}/by-hand": submissions.by_hand,
}


def application(book: Classbook, keys: Keys, author: str) -> Doors:
    """The desk over one class, as ASGI.

    Parameters
    ----------
    author
        Who decides, as long as a browser does not say otherwise.
    """
    called = f"{keys.cookie_name}-author"

    def endpoint(handler: Handler) -> Callable[[Request], Awaitable[Response]]:
        async def answer(request: Request) -> Response:
            try:
                ask = await asking.read(request, called, author)
                return await asyncio.get_running_loop().run_in_executor(book.thread, handler, book, ask)
            except asking.TooLargeError:
                return _refused("That is more than a form of this desk can hold.", 413)
            except OvertakenError as problem:
                return _refused(
                    f"{problem}. Nothing of yours was recorded: go back, load the page again and decide anew.", 409
                )
            except RequestError as problem:
                return _refused(str(problem), 400)
            except Exception as problem:  # the next page may well be fine
                return _refused(f"The desk itself failed: {type(problem).__name__}: {problem}", 500)

        return answer

    async def say_who(request: Request) -> Response:
        ask = await asking.read(request, called, author)
        answer = RedirectResponse("/", 303)
        answer.set_cookie(called, asking.in_cookie(asking.name(ask.text("name"))), httponly=True, samesite="strict")
        return answer

    routes = [
        *(Route(path, endpoint(handler), methods=["GET"]) for path, handler in PAGES.items()),
        *(Route(path, endpoint(handler), methods=["POST"]) for path, handler in WRITES.items()),
        Route("/who", say_who, methods=["POST"]),
        *(Route(f"/static/{name}", _static(name), methods=["GET"]) for name in STATIC),
    ]
    nothing = {404: lambda request, problem: _refused("There is no such page.", 404)}
    return Doors(Starlette(routes=routes, exception_handlers=nothing), keys)


def _refused(message: str, status: int) -> Response:
    return page("refused.html.j2", status, message=message)


def _static(name: str) -> Callable[[Request], Awaitable[Response]]:
    path, kind = STATIC[name]

    async def answer(request: Request) -> Response:
        return Response(path.read_bytes(), media_type=kind)

    return answer
