"""Patches in the notation of `diff -u`, without numbers of lines: how a row of the corpus changes a file of its base."""

from __future__ import annotations


def patched(text: str, patch: str) -> str:
    """Return a text with each hunk of a patch applied.

    A line that begins with ``-`` is taken away, one with ``+`` is added, one with a space (and an empty one) stays where it is;
    ``@@`` separates hunks.

    Raises
    ------
    ValueError
        If the lines that a hunk expects are not there exactly once, or two hunks overlap: the case would then not be what its
        row says.
    """
    lines, places = text.split("\n"), []
    for hunk in _hunks(patch):
        old = [line[1:] for line in hunk if line[:1] != "+"]
        new = [line[1:] for line in hunk if line[:1] != "-"]
        found = [i for i in range(len(lines) - len(old) + 1) if lines[i] == old[0] and lines[i : i + len(old)] == old]
        if len(found) != 1:
            raise ValueError(f"the lines {old} are there {len(found)} times, once is needed")
        places.append((found[0], found[0] + len(old), new))
    result: list[str] = []
    end = 0
    for first, last, new in sorted(places):
        if first < end:
            raise ValueError(f"the hunk of {new} overlaps another one")
        result += [*lines[end:first], *new]
        end = last
    return "\n".join([*result, *lines[end:]])


def _hunks(patch: str) -> list[list[str]]:
    hunks: list[list[str]] = [[]]
    for line in patch.removesuffix("\n").split("\n"):
        if line == "@@":
            hunks.append([])
        elif line[:1] in ("", " ", "-", "+"):
            hunks[-1].append(line)
        else:
            raise ValueError(f"a line of a patch begins with a space, -, + or is @@: {line!r}")
    return [hunk for hunk in hunks if hunk]
