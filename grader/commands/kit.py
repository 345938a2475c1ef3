"""`imugrade kit`: files for students and platforms."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from grader.base.errors import RequestError
from grader.commands.common import RubricOption, SeedOption, WeakSecretOption


def kit(
    out: Annotated[
        Path | None, typer.Argument(metavar="OUT_DIR", help="A new folder for students.", show_default=False)
    ] = None,
    *,
    gradescope: Annotated[
        Path | None, typer.Option("--gradescope", metavar="FILE", help="Write an autograder.zip.")
    ] = None,
    classroom50: Annotated[
        Path | None, typer.Option("--classroom50", metavar="DIR", help="Write an autograder for Classroom 50.")
    ] = None,
    github: Annotated[
        Path | None, typer.Option("--github", metavar="DIR", help="Write a workflow into a repository.")
    ] = None,
    gitlab: Annotated[
        Path | None, typer.Option("--gitlab", metavar="DIR", help="Write a pipeline into a repository.")
    ] = None,
    rubric: RubricOption = None,
    seed: SeedOption = None,
    weak_secret: WeakSecretOption = False,
) -> int:
    """Write the files for students or a platform, without the solution.

    Hidden scenarios are written only for Gradescope, and only with a seed: everywhere else students could read them.

    \b
    Examples:
      imugrade kit lab-04-01
      IMUGRADE_SEED=... imugrade kit --gradescope autograder.zip
      imugrade kit --github starter-repository
    """
    from grader.course.run import secret_strength  # noqa: PLC0415
    from grader.engine import rubric as rubrics  # noqa: PLC0415
    from grader.engine.check_runner import known_checks  # noqa: PLC0415
    from grader.engine.lab_registry import chosen_lab  # noqa: PLC0415
    from grader.kit import give  # noqa: PLC0415

    if all(place is None for place in (out, gradescope, classroom50, github, gitlab)):
        raise RequestError("kit: nothing to write; give OUT_DIR, --gradescope, --classroom50, --github or --gitlab")
    if gradescope and not weak_secret:
        secret_strength.refuse_guessable(seed)
    lab = chosen_lab()
    given = rubrics.load(lab, rubric)
    rubrics.match_checks(given, {id_: each.title for id_, each in known_checks(lab, given.own_checks).items()})
    hidden = lab.truth(seed, given.settings) if gradescope and seed is not None else None
    jobs = {"classroom50": classroom50, "github": github, "gitlab": gitlab}
    kits = [partial(give.student, lab, out, rubric)] if out else []
    kits += [partial(give.gradescope, lab, gradescope, rubric, hidden)] if gradescope else []
    kits += [partial(give.job, platform, lab, place, rubric) for platform, place in jobs.items() if place]
    for write in kits:
        written = write()
        print(f"{written.place}  for {written.title}; {written.scenarios}")
    return 0
