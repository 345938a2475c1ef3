"""F-strings as Python 3.12 reads them, for a Python that is older: inside of braces any quotes and backslashes may stand (PEP 701).

A field's strings are set so that older releases read them, and the f-string around them gets quotes that nothing in it has.
"""

from __future__ import annotations

import ast
import re
import sys

_LONGEST = 400_000  # characters
_BEGINS = re.compile(r"(?<!\w)([rRbBuUfF]{0,2})('''|\"\"\"|'|\")")
_WIDE = ("'''", '"""')


def reworded(text: str) -> str | None:
    """The same program; None where this Python reads such f-strings itself, or a string of it has no end."""
    if sys.version_info >= (3, 12) or len(text) > _LONGEST:
        return None
    try:
        return _reworded(text)
    except (ValueError, IndexError, StopIteration, SyntaxError, RecursionError):
        return None


def _reworded(text: str) -> str:
    done, at = [], 0
    while at < len(text):
        if text[at] == "#":
            end = text.find("\n", at)
            end = len(text) if end < 0 else end
            piece = text[at:end]
        elif begin := _BEGINS.match(text, at):
            piece, end = _string(text, begin)
        else:
            piece, end = text[at], at + 1
        done.append(piece)
        at = end
    return "".join(done)


def _string(text: str, begin: re.Match[str]) -> tuple[str, int]:
    """A string as older releases read it, and where it ends in the text."""
    prefix, quote = begin.groups()
    if "f" not in prefix.lower():
        end = _end(text, begin.end(), quote)
        return text[begin.start() : end], end
    parts, at = [], begin.end()
    while not text.startswith(quote, at):
        if text[at] == "{" and not text.startswith("{{", at):
            piece, at = _field(text, at)
        else:
            wide = 2 if text[at] == "\\" or text.startswith(("{{", "}}"), at) else 1
            piece, at = text[at : at + wide], at + wide
        parts.append(piece)
    body, end = "".join(parts), at + len(quote)
    if body == text[begin.end() : at] and quote not in body:
        return text[begin.start() : end], end
    around = next(wide for wide in _WIDE if wide not in body and not body.endswith(wide[0]))
    return prefix + around + body + around, end


def _end(text: str, at: int, quote: str) -> int:
    while not text.startswith(quote, at):
        at += 2 if text[at] == "\\" else 1
    return at + len(quote)


def _field(text: str, at: int) -> tuple[str, int]:
    """What stands in braces, from the first to the last of them."""
    parts, depth = [], 0
    while True:
        if begin := _BEGINS.match(text, at):
            piece, end = _string(text, begin)
            if "\\" in piece and "f" not in begin[1].lower():
                piece = _without_backslashes(piece)
        else:
            piece, end = text[at], at + 1
            depth += (piece in "([{") - (piece in ")]}")
        parts.append(piece)
        at = end
        if not depth:
            return "".join(parts), at


def _without_backslashes(literal: str) -> str:
    value = ast.literal_eval(literal)
    content = value if isinstance(value, bytes) else value.encode("utf-8", "surrogatepass")
    made = f"bytes.fromhex('{content.hex()}')"
    return made if isinstance(value, bytes) else f"{made}.decode('utf-8', 'surrogatepass')"
