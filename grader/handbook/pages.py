"""The pages of the handbook: their names, and how each is made from the code."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import typer

from grader.engine.mistakes import catalogue
from grader.engine.rubric import load
from grader.ground.package_data import beside
from grader.handbook import commands, entries, flow, isolation, modules, platforms, rubric_keys
from grader.labs.imu.lab import LAB

FOLDER = beside(__package__, "")
_MADE = "<!-- Made by `python -m grader.handbook`; edit the code that it is made from. -->\n\n"

_INDEX = """# Handbook

| Page | Tells |
| --- | --- |
| [Commands](commands.md) | every command with its options and exit codes |
| [At work](working.md) | for students: a check as a program, the checks in pytest and in an editor |
| [Checks](checks.md) | what is checked, for how many points |
| [Mistakes](mistakes.md) | every mistake that a report may name, with the lines that mend it |
| [Faults](faults.md) | which checks each mistake of the corpus loses |
| [Rubric](rubric.md) | every key of `rubric.yaml` |
| [A class](classes.md) | from the download to the upload: rosters, lateness, points by hand, regrades |
| [The review desk](desk.md) | what needs a look, code beside reports, one decision for many, appeals, what a rubric would cost |
| [Platforms](platforms.md) | GitHub, Gradescope, Classroom 50, GitLab, PrairieLearn |
| [Clusters](clusters.md) | `--cluster` on SLURM and Kubernetes, and how many machines a class needs |
| [Isolation](isolation.md) | what each rung promises, and what the attacks on it came to |
| [Architecture](architecture.md) | the way of a submission, and what each module is for |
| [How to add](contributing.md) | a check, a mistake, a language, a bonus, a lab, a platform |

`imugrade explain ID` prints one entry of *Checks* or *Mistakes*.
"""


def pages(app: typer.Typer) -> Mapping[str, str]:
    """All pages by file name.

    Parameters
    ----------
    app
        The command line: it stands above the handbook, so it is handed in.
    """
    made = {
        "README.md": _INDEX,
        "commands.md": commands.page(app),
        "working.md": (FOLDER / "working.txt").read_text(encoding="utf-8"),
        "checks.md": _checks(),
        "mistakes.md": _mistakes(),
        "rubric.md": rubric_keys.page(),
        "platforms.md": platforms.page(),
        "classes.md": platforms.classes(),
        "faults.md": (FOLDER / "faults.txt").read_text(encoding="utf-8"),
        "desk.md": (FOLDER / "desk.txt").read_text(encoding="utf-8"),
        "clusters.md": (FOLDER / "clusters.txt").read_text(encoding="utf-8"),
        "isolation.md": isolation.page(),
        "architecture.md": modules.page(),
        "contributing.md": platforms.contributing(),
    }
    return {**{name: _MADE + text for name, text in made.items()}, "flow.svg": flow.picture()}


def write(app: typer.Typer) -> list[Path]:
    """Write the pages that changed, and return them."""
    changed = [(FOLDER / name, text) for name, text in pages(app).items() if _now(FOLDER / name) != text]
    for path, text in changed:
        path.write_text(text, encoding="utf-8", newline="\n")
    return [path for path, _ in changed]


def _now(path: Path) -> str:
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def _checks() -> str:
    return "\n".join(["# Checks\n", *_check_entries()])


def _check_entries() -> Iterator[str]:
    yield (
        "Points are those of the shipped rubric. The same checks run on the public scenarios (`imugrade check`) and on the\n"
        "hidden ones (`imugrade grade` with a seed), in which the robot itself is another one.\n"
    )
    for part in load(LAB).parts:
        yield entries.part(part, level=2)


def _mistakes() -> str:
    lines = [
        "<!-- fmt: off -->\n",  # ruff formats code in Markdown too; these lines stand as the catalogue has them
        "# Mistakes\n",
        "A mistake is named only where the numbers show it: its prediction fits what came, and no other's does.\n",
    ]
    for group, title in entries.GROUPS.items():
        found = [mistake for mistake in catalogue(LAB).values() if mistake.group == group]
        lines += [f"## {title}\n", *(entries.mistake(mistake, level=3) for mistake in found)]
    return "\n".join(lines)
