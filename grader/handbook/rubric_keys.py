"""The page of the rubric: its keys, and the shipped file, whose comments give the reasons."""

from __future__ import annotations

from collections.abc import Sequence

from grader.engine.lab import Part
from grader.engine.rubric import shipped
from grader.ground.package_data import beside
from grader.labs.imu.lab import LAB


def _one_of(parts: Sequence[Part]) -> str:
    *first, last = (f"`{part.id}`" for part in parts)
    return f"{', '.join(first)} or {last}"


KEYS = {
    "criteria": "the five criteria of the sheet, each once, in any order",
    "criteria.id": _one_of(LAB.parts),
    "criteria.title": "what reports and gradebooks call it",
    "criteria.points": "what it is worth, 0 to 1000, two decimals at most",
    "criteria.checks": "`name: weight` for each check; points are shared by weight, and always sum to the criterion's",
    "extra_credit": "what extensions earn beside the score; left out: nothing",
    "extra_credit.each": "points of each extension that names none of its own",
    "extra_credit.cap": "what all of them together earn at most; left out: their sum",
    "extensions": "the sheet's four extensions, each once",
    "extensions.id": _one_of(LAB.bonuses),
    "extensions.title": "what reports call it",
    "extensions.file": "the file that it is looked for in",
    "extensions.points": "0: reported, never counted; above 0: extra credit",
    "extensions.checks": "`name: weight` for each check",
    "mistakes": "`name: points` lines: what a named mistake costs in a check that is lost through it, within the check's points",
    "limits": "CPU time of the student's code",
    "limits.call_cpu_s": "seconds for one call",
    "limits.submission_cpu_s": "seconds for all calls of a submission",
    "late": "what lateness costs, beside the marks; left out: nothing",
    "late.due": "when the lab is due: date and time with the offset from UTC",
    "late.grace_minutes": "up to that it is not late; later than that it counts from `due` on",
    "late.per_day": "points for each day begun after `due`, or a percentage of the criteria's points",
    "late.cut_off_days": "after so many days nothing counts; left out: no such end",
    "late.tz": "time zone by whose clock days are counted, `Europe/Berlin` for example; left out: 24 hours a day",
    "late.extensions": "`who: date` lines; who is an id, a name or an e-mail address",
    "model": "the model that is simulated; may be left out",
    "model.path": "an MJCF file, relative to the rubric; left out: the lab model",
    "model.sensors": "the two sensors of the IMU",
    "model.sensors.accelerometer": "name of the accelerometer; left out: `torso_accelerometer`",
    "model.sensors.gyroscope": "name of the gyroscope; left out: `torso_gyroscope`",
}

_FROM_THE_RECORD = """\
## After a class was graded

Change points, weights, prices of mistakes, extra credit or the late policy, and give the same `grade` command again: the
class is marked from what is on record, and no code runs. Only other limits, another model or another seed ask the code again.
Points by hand stay; `grade` names those whose automatic marks have moved."""

_OWN_ROBOT = """\
## A robot of your own

```yaml
model:
  path: my-humanoid.xml
  sensors:
    accelerometer: torso_accel
    gyroscope: torso_gyro
```

With this, reading, collection, noise and plots are asked on your model with your sensors' names, and under a secret
on variants of it. The sheet's facts about the lab's robot are not asked: yours may fall, or hang on a stand. What
students load at the sheet's path, or at any path that ends in your file's name, is your robot. A kit that is
written with this rubric holds the model and checks with it; `check`, `ci`, `grade` and `traces` take the rubric
with `--rubric`.

Included files, meshes, height fields and textures are read once, where the traces are recorded, and the model
becomes one text: meshes that touch become their convex hulls, which is what MuJoCo collides, what only shows is
left out, and bodies keep their inertia. That text is what the kit holds. The extension *Multiple IMUs* stays with
the lab's robot, which has four; the others use worlds of their own or your robot.

Refused, with the line, before anything is graded: a model that MuJoCo cannot load, with the included file that is
missing; one without a joint, as there is no velocity to push; a sensor that is missing or of another type; a
simulation that becomes unstable after the push; more than 700 kB of text. Where the push moves nothing that the IMU
reads, `grade` says so: whether a run was pushed, and from where it started, can then hardly be told from its rows."""


_OWN_CHECKS = """\
## Checks of your own

Files in a folder `checks` beside your rubric hold checks of your own, with the decorator and the fixtures of the shipped
ones. A file is named `check_*.py`, a function `check_*`; the rubric names the check and weighs it, under a criterion or an
extension of the sheet. This one stands in `checks/check_step.py`:

```python
{example}
```

and its line under the checks of `filtering` is

```yaml
      settles_after_a_step: 4
```

The docstring is the sentence that a student reads. Return where all is earned; raise `Lost` where points are lost, with what was
expected and what came, `keeps=0.5` for a part of them and a `hint` where you have one. `off` is what is said in place of your
numbers where the scenarios are hidden. `student` asks questions of the code in its box: `read`, `simulate`, `noise` and `filter`,
as the checks in `grader/labs/imu/checks` do; the first argument names the question, which is asked once. `truth` holds the
scenarios that `imugrade traces list` lists, `truth["push"]["acceleration"]` for one.

Your checks are your code, and run where marks are decided: import nothing there that a student wrote. Any exception but a
finding leaves the check open, and the report says so. What stands in the folder is part of the rubric's hash, so a change
of it grades anew; `--cluster` and kits carry it. `pytest --imugrade --imugrade-rubric FILE` shows them among the others."""


def page() -> str:
    """The table of keys, what happens to a slip, and the file."""
    rows = "\n".join(f"| `{key}` | {tells} |" for key, tells in KEYS.items())
    text = shipped(LAB).read_text(encoding="utf-8").strip()
    example = beside(__package__, "own_check.txt").read_text(encoding="utf-8").strip()
    return (
        "# Rubric\n\n"
        "Copy `rubric.yaml`, edit the copy, and name it with `--rubric FILE`. Every check that exists must stand in it, and\n"
        "nothing else may: a slip stops the run before anything is graded, with the number of the line.\n\n"
        f"| Key | Tells |\n| --- | --- |\n{rows}\n\n"
        f"{_FROM_THE_RECORD}\n\n"
        f"{_OWN_ROBOT}\n\n"
        f"{_OWN_CHECKS.format(example=example)}\n\n"
        f"## The shipped one\n\n```yaml\n{text}\n```\n"
    )
