"""Refusal of a secret that somebody can guess: hidden scenarios are hidden only as long as their secret is."""

from __future__ import annotations

import re

from grader.base.errors import RequestError

MIN_LENGTH = 12
"""Fewest characters of a secret. Twelve random letters and digits are 71 bits, more than anybody can try."""
MIN_WORDS = 4
"""Fewest words of a secret that consists of words. A list has some ten thousand, so four of them are 53 bits."""
MIN_DIFFERENT = 6
"""Fewest different characters, so that a repeated key is no secret."""
MIN_RUNS = 6
"""Fewest runs of letters and digits of a secret with fewer words: random characters alternate more often than names and years."""
MIN_DIGITS = 16
"""Fewest digits of a secret that is mostly a number: 53 bits."""
_WORD = r"[A-Z]?[^\W\d_A-Z]+|[A-Z]+"


def refuse_guessable(secret: str | None) -> None:
    """Raise RequestError if students can guess the secret, and thus the hidden scenarios. None, for public scenarios, passes."""
    why = guessable(secret) if secret is not None else ""
    if why:
        raise RequestError(
            f"the secret in IMUGRADE_SEED can be guessed: {why}. Make one with `openssl rand -hex 16` and keep it until the course "
            "ends, or add --weak-secret"
        )


def guessable(secret: str) -> str:
    """Return why a secret can be guessed, as the end of an error message; "" if it is strong enough."""
    if len(secret) < MIN_LENGTH:
        return f"it has fewer than {MIN_LENGTH} characters"
    if len(set(secret)) < MIN_DIFFERENT:
        return f"it has fewer than {MIN_DIFFERENT} different characters"
    words, runs = re.findall(_WORD, secret), re.findall(rf"{_WORD}|\d+", secret)
    if len(words) < MIN_WORDS and len(runs) < MIN_RUNS and sum(map(str.isdigit, secret)) < MIN_DIGITS:
        return f"it is fewer than {MIN_WORDS} words, or a short number"
    return ""
