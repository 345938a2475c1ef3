"""Make text from strangers safe to show: file names, printed lines, messages of a student's code.

`printable` is for text that people read, `csv_cell` for a cell of a spreadsheet. Neither makes text safe in HTML, XML or CI
commands: the modules that write those escape it themselves.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence

# Cc: C0 and C1 controls, so ESC and with it every ANSI sequence. Cf: bidi controls, zero-width characters, tags.
# Cs: lone surrogates, which no encoder takes. Zl, Zp: line ends that only some readers break at.
_HIDDEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
_JOINERS = frozenset("\u200c\u200d")  # Persian, Indic scripts and emoji need them, and they reorder nothing
_KEPT = str.maketrans("", "", "\n\t")
_FORMULA = tuple("=+-@\t\r\n＝＋－＠")  # Excel and LibreOffice read the full-width forms as well


def _noncharacter(code: int) -> bool:
    """Return whether Unicode reserves the code point for ever; `printable` escapes these, because XML refuses two of them."""
    return code & 0xFFFE == 0xFFFE or 0xFDD0 <= code <= 0xFDEF


def _shown(char: str) -> str:
    code = ord(char)
    if char in _JOINERS or not (unicodedata.category(char) in _HIDDEN or _noncharacter(code)):
        return char
    if code <= 0xFF:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code <= 0xFFFF else f"\\U{code:08x}"


def printable(text: str, limit: int = 200, *, newlines: bool = False) -> str:
    r"""Return untrusted text with its control characters escaped, so that a terminal, a page and a log can show it as it is.

    Parameters
    ----------
    text : any text, lone surrogates included
    limit : largest number of characters to return; a longer text ends in an ellipsis
    newlines : keep line ends (``\r\n`` and ``\r`` become ``\n``) and tabs, which otherwise are escaped like other controls

    Returns
    -------
    str
        Controls, ANSI escapes, bidirectional controls, lone surrogates and noncharacters appear as ``\x1b`` or ``\u202e``.
    """
    head = text[: 2 * limit + 2]  # a \r\n is one line end, and no flood is worked through
    if newlines:
        head = head.replace("\r\n", "\n").replace("\r", "\n")
    shown = head[: limit + 1]
    # Most text is printable, and this is asked a million times a class.
    if not (shown.translate(_KEPT) if newlines else shown).isprintable():
        shown = "".join(char if newlines and char in "\n\t" else _shown(char) for char in shown)
    return shown if len(shown) <= limit else shown[: max(limit - 1, 0)] + "…"[:limit]


def enumerated(names: Iterable[str], last: str = "and") -> str:
    """Return names as part of a sentence, ``a, b and c``, where `last` stands before the last name; "" without names."""
    *others, end = names or [""]
    return f"{', '.join(others)} {last} {end}" if others else end


def decimal(text: str) -> float | None:
    """Return the number that a person wrote, with a decimal point or comma; None if the text is no such number.

    `float` alone would also take ``1_0``, ``nan`` and digits of other scripts, which a spreadsheet reads in another way.
    """
    plain = text.strip().replace(",", ".")
    return float(plain) if _DECIMAL.fullmatch(plain) else None


_DECIMAL = re.compile(r"[+-]?(\d{1,15}(\.\d{0,20})?|\.\d{1,20})(e[+-]?\d\d?)?", re.ASCII | re.IGNORECASE)


def some(names: Sequence[str], most: int, between: str = ", ") -> str:
    """Return the first `most` names as printable text, joined by `between`, and how many others there are: ``a, b and 3 more``."""
    shown = between.join(printable(name, 120) for name in names[:most])
    return f"{shown} and {len(names) - most:,} more" if len(names) > most else shown


def csv_cell(text: str) -> str:
    """Return text for a CSV cell, with an apostrophe in front if a spreadsheet might run it as a formula.

    Do not pass a number: ``-1`` would get the apostrophe, too, as a formula may begin with a sign.
    """
    return f"'{text}" if text.startswith(_FORMULA) else text
