"""Access control of the review desk: localhost only, token then cookie, same-origin writes.

The pages show hostile text. The Content-Security-Policy allows only the desk's own script and no request to another host.
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

TOKEN_PATH = "/enter"
POLICY = (
    "default-src 'none'; style-src 'self'; script-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "form-action 'self'; "
    "base-uri 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",  # with `no-referrer` a browser sends no Origin with our own forms
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


@dataclass(frozen=True)
class Keys:
    """Secrets of the desk that runs on `port`: the token in the printed address, and the cookie that the token is exchanged for.

    Neither reveals the other.
    """

    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)
    cookie: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)

    @property
    def first_address(self) -> str:
        return f"http://127.0.0.1:{self.port}{TOKEN_PATH}?token={self.token}"

    @property
    def hosts(self) -> tuple[str, ...]:
        return f"127.0.0.1:{self.port}", f"localhost:{self.port}"

    @property
    def cookie_name(self) -> str:
        """Return a cookie name that contains the port, because browsers share cookies between ports of one host."""
        return f"imugrade-desk-{self.port}"


class AccessControl:
    """ASGI middleware before the desk that refuses foreign host names, browsers without its cookie and cross-origin writes."""

    def __init__(self, app: ASGIApp, keys: Keys) -> None:
        self._app, self._keys = app, keys

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return
        refusal = self._refusal(scope)
        if refusal is not None:
            await refusal(scope, receive, _with_headers(send))
        elif scope["path"] == TOKEN_PATH:
            await self._set_cookie(scope)(scope, receive, _with_headers(send))
        else:
            await self._app(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope) -> Response | None:
        """Return the response that refuses a request: wrong host, method or origin, or no cookie; None if it is allowed."""
        headers = Headers(scope=scope)
        if headers.get("host") not in self._keys.hosts:
            return PlainTextResponse("The review desk is only available at its own address.", 421)
        if scope["method"] not in ("GET", "HEAD", "POST"):
            return PlainTextResponse("This method is not allowed.", 405, {"Allow": "GET, HEAD, POST"})
        if scope["method"] == "POST" and headers.get("origin") != f"http://{headers['host']}":
            return PlainTextResponse("Only a page of this review desk may change something.", 403)
        if scope["path"] != TOKEN_PATH and not self._has_cookie(headers):
            return PlainTextResponse("Open the full address that `imugrade review` printed.", 403)
        return None

    def _has_cookie(self, headers: Headers) -> bool:
        """Return whether a request has the cookie of this desk, which a browser gets by opening the printed address."""
        try:
            found = SimpleCookie(headers.get("cookie", "")[:4096]).get(self._keys.cookie_name)
        except CookieError:
            return False
        return found is not None and _same(found.value, self._keys.cookie)

    def _set_cookie(self, scope: Scope) -> Response:
        """Answer the printed address: set the cookie and go to the first page, or refuse a wrong token."""
        given = parse_qs(scope["query_string"][:512].decode("latin-1")).get("token", [""])[0]
        if not _same(given, self._keys.token):
            return PlainTextResponse("This is not the address that `imugrade review` printed.", 403)
        answer = RedirectResponse("/", 303)
        answer.set_cookie(self._keys.cookie_name, self._keys.cookie, httponly=True, samesite="strict")
        return answer


def _same(given: str, wanted: str) -> bool:
    return secrets.compare_digest(given.encode(), wanted.encode())


def _with_headers(send: Send) -> Send:
    """Return a `send` that adds the security headers to each response, also to refusals."""

    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers[name] = value
        await send(message)

    return sent
