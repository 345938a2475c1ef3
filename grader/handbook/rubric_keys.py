"""The page of the rubric: its keys, and the shipped file, whose comments give the reasons."""

from __future__ import annotations

from grader.rubric import shipped

KEYS = {
    "criteria": "the five criteria of the sheet, each once, in any order",
    "criteria.id": "`sensor_access`, `data_collection`, `visualization`, `noise_model` or `filtering`",
    "criteria.title": "what reports and gradebooks call it",
    "criteria.points": "what it is worth, 0 to 1000, two decimals at most",
    "criteria.checks": "`name: weight` for each check; points are shared by weight, and always sum to the criterion's",
    "extra_credit": "what extensions earn beside the score; left out: nothing",
    "extra_credit.each": "points of each extension that names none of its own",
    "extra_credit.cap": "what all of them together earn at most; left out: their sum",
    "extensions": "the sheet's four extensions, each once",
    "extensions.id": "`complementary_filter`, `allan_variance`, `multiple_imus` or `realtime_visualization`",
    "extensions.title": "what reports call it",
    "extensions.file": "the file that it is looked for in",
    "extensions.points": "0: reported, never counted; above 0: extra credit",
    "extensions.checks": "`name: weight` for each check",
    "limits": "CPU time of the student's code",
    "limits.call_cpu_s": "seconds for one call",
    "limits.submission_cpu_s": "seconds for all calls of a submission",
    "late": "what lateness costs, beside the marks; left out: nothing",
    "late.due": "when the lab is due: date and time with the offset from UTC",
    "late.grace_minutes": "up to that it is not late; later than that it counts from `due` on",
    "late.per_day": "points for each day begun after `due`, or a percentage of the criteria's points",
    "late.cut_off_days": "after so many days nothing counts; left out: no such end",
    "late.extensions": "`who: date` lines; who is an id, a name or an e-mail address",
    "model": "the model that is simulated; may be left out",
    "model.path": "an MJCF file, relative to the rubric; left out: the lab model",
    "model.sensors": "the two sensors of the IMU",
    "model.sensors.accelerometer": "name of the accelerometer",
    "model.sensors.gyroscope": "name of the gyroscope",
}


def page() -> str:
    """The table of keys, what happens to a slip, and the file."""
    rows = "\n".join(f"| `{key}` | {tells} |" for key, tells in KEYS.items())
    text = shipped().read_text(encoding="utf-8").strip()
    return (
        "# Rubric\n\n"
        "Copy `rubric.yaml`, edit the copy, and name it with `--rubric FILE`. Every check that exists must stand in it, and\n"
        "nothing else may: a slip stops the run before anything is graded, with the number of the line.\n\n"
        f"| Key | Tells |\n| --- | --- |\n{rows}\n\n"
        f"## The shipped one\n\n```yaml\n{text}\n```\n"
    )
