"""Rename files as Python needs them: suffixes in lower case, and without the `.txt` that editors and mail programs add."""

from __future__ import annotations

from collections.abc import Collection

from grader.intake.file_budget import FileBudget, listing
from grader.intake.names import CODE, folded, has_suffix, is_code

_ADDED = ".txt"
_LOWERED = (*CODE, ".png")


def in_lower_case(budget: FileBudget, required: Collection[str]) -> None:
    """Rename files such as `imu_reader.PY` to `imu_reader.py`, because Python imports no other suffix; a remark reports it.

    A name all in capitals becomes lower case, and a `required` one is spelled as the lab asks. A file keeps its name if another
    file has the new one.
    """
    asked = {folded(name): name for name in required}
    renamed = []
    for path in sorted(path for path in budget.files if has_suffix(path, _LOWERED) and not path.endswith(_LOWERED)):
        folder, slash, name = path.rpartition("/")
        stem, _, suffix = name.rpartition(".")
        plain = asked.get(folded(name)) or f"{stem.lower() if stem.isupper() else stem}.{suffix.lower()}"
        if folder + slash + plain not in budget.files:
            budget.files[folder + slash + plain] = budget.files.pop(path)
            renamed.append(path)
    if renamed:
        budget.remarks.append(f"Read under a name in small letters, as Python needs it: {listing(renamed)}.")


def as_programs(budget: FileBudget, required: Collection[str]) -> None:
    """Rename `filters.py.txt` to `filters.py`, because mail programs add `.txt`; a remark reports it.

    If there is no code, `filters.txt` is renamed, too, if `filters.py` is `required`. A file stays if its new name is taken.
    """
    there = set(map(folded, budget.files))
    no_code = not any(map(is_code, budget.files))
    taken = []
    for path in sorted(path for path in budget.files if path.lower().endswith(_ADDED)):
        program = path[: -len(_ADDED)]
        if no_code and f"{program.rpartition('/')[2]}.py" in required:
            program += ".py"
        if is_code(program) and folded(program) not in there:
            budget.files[program] = budget.files.pop(path)
            there.add(folded(program))
            taken.append(path)
    if taken:
        budget.remarks.append(f"Taken for programs although they are called texts: {listing(taken)}.")
