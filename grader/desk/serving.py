"""HTTP server of the review desk, bound to the loopback address so that no other machine reaches it."""

from __future__ import annotations

import socket
from collections.abc import Callable
from contextlib import suppress

import uvicorn

from grader.base.errors import RequestError
from grader.desk.app import application
from grader.desk.auth import Keys
from grader.desk.classbook import Classbook

_LOOPBACK = "127.0.0.1"
_AT_ONCE = 64


def open_socket(port: int) -> socket.socket:
    """Open a socket on the loopback address; port 0 takes any free port. RequestError if the port is taken."""
    made = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind((_LOOPBACK, port))
        made.listen(_AT_ONCE)  # a browser that connects before the server runs waits
    except OSError as error:
        made.close()
        raise RequestError(f"--port {port}: {error.strerror}; choose another, or none for any that is free") from error
    return made


def server(book: Classbook, keys: Keys, author: str) -> uvicorn.Server:
    """Return the HTTP server of the desk, which `serve` starts.

    `keys` are the access token and the cookie that let a browser in. `author` is the default name under which decisions are stored.
    """
    config = uvicorn.Config(
        application(book, keys, author),
        log_level="warning",
        access_log=False,
        lifespan="off",
        server_header=False,
        proxy_headers=False,
        ws="none",
        limit_concurrency=_AT_ONCE,
        timeout_graceful_shutdown=2,
    )
    return uvicorn.Server(config)


def serve(book: Classbook, author: str, port: int, announce: Callable[[str], None]) -> None:
    """Run the desk until interrupted; RequestError if the port is taken.

    `author` is the default name under which decisions are stored. `announce` gets the address with the access token.
    """
    with open_socket(port) as listening:
        keys = Keys(listening.getsockname()[1])
        made = server(book, keys, author)
        with suppress(KeyboardInterrupt):  # Ctrl-C ends the desk
            announce(keys.first_address)
            made.run(sockets=[listening])
