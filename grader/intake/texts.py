"""Programs that came as texts: editors and mail programs add a `.txt` that the folder's window hides."""

from __future__ import annotations

from collections.abc import Collection

from grader.intake.names import folded, is_code
from grader.intake.pile import Pile, listing

_ADDED = ".txt"


def as_programs(pile: Pile, required: Collection[str]) -> None:
    """Take `filters.py.txt` for `filters.py`, and where there is no code at all `filters.txt`, if the lab asks for `filters.py`."""
    there = set(map(folded, pile.files))
    no_code = not any(map(is_code, pile.files))
    taken = []
    for path in sorted(path for path in pile.files if path.lower().endswith(_ADDED)):
        program = path[: -len(_ADDED)]
        if no_code and f"{program.rpartition('/')[2]}.py" in required:
            program += ".py"
        if is_code(program) and folded(program) not in there:
            pile.files[program] = pile.files.pop(path)
            there.add(folded(program))
            taken.append(path)
    if taken:
        pile.remarks.append(f"Taken for programs although they are called texts: {listing(taken)}.")
