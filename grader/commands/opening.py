"""First lines of `imugrade check`, printed before any code runs: the files found, and the checks to run."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from grader.base.text import printable

if TYPE_CHECKING:  # these lines are printed before slow imports
    from grader.engine.lab import Lab
    from grader.engine.rubric import Rubric
    from grader.engine.traces import Traces
    from grader.intake import Submission

OTHERS = "another robot of the same kind, its sensors in another order, other numbers"


def checking_line(path: Path) -> str:
    """Return the first line of `imugrade check`, which names the submission at once, before anything is read or imported."""
    return f"checking {printable(Path(os.path.abspath(path)).name, 120)} …"  # "." has a name too


def found(lab: Lab, submission: Submission) -> str:
    """Return a line on lab files found or missing, to reveal a wrong folder; if no lab .py is there, a notebook stands for all."""
    asked_for = (*lab.files, *lab.pictures)
    there = [name for name in asked_for if name in submission.files]
    notebooks = [] if set(there) & set(lab.files) else sorted(n for n in submission.files if n.endswith(".ipynb"))
    absent = [name for name in (lab.pictures if notebooks else asked_for) if name not in submission.files]
    there = [*(f"{name} (for {', '.join(lab.files)})" for name in notebooks[:1]), *there]
    said = [f"{', '.join(there)} found"] if there else []
    said += [f"no {', no '.join(absent)}"] if absent else []
    if not any(part.attempted_in(submission.files) for part in (*lab.parts, *lab.bonuses)):
        said += ["nor anything else that the lab asks for: is this the right folder?"]
    return "; ".join(said)


def waiting(submission: Submission, rubric: Rubric, traces: Traces, only: str | None, *, secret: bool) -> str:
    """Return a line with the number of checks to run on public scenarios, and a notice of hidden ones, which `imugrade grade` uses.

    `only` is the id of a criterion or extension; None: all criteria, and the extensions whose file `submission` has. If `secret`,
    the seed of the hidden scenarios is set here (IMUGRADE_SEED), and the notice has their number: how many scenarios in `traces`
    depend on a seed. Else it says that the instructor may use hidden scenarios.
    """
    extensions = [part for part in rubric.extensions if part.file in submission.files or only == part.id]
    count = sum(len(part.checks) for part in (*rubric.criteria, *extensions) if only in (None, part.id))
    public = f"{count} public check{'s' * (count != 1)}."
    if not secret:
        return f"{public} Your instructor may grade with hidden scenarios: {OTHERS}."
    hidden = len(traces.scenarios.keys() - rubric.lab.same_for_all)
    return f"{public} {hidden} hidden scenarios wait: {OTHERS}; imugrade grade uses them."
