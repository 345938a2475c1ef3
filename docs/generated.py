"""Parts of the documentation that are generated from the code.

They stand in the pages between two comments, so that a repository's web page shows them, too:
`<!-- generated: NAME -->` and `<!-- end: NAME -->`. `python -m tests.regenerate docs` writes them anew.
"""

from __future__ import annotations

import ast
import inspect
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from grader import cli
from grader.base.text import enumerated
from grader.engine import results
from grader.engine.faults import catalogue
from grader.engine.findings import CheckFailed, Size, StudentError, raised
from grader.engine.lab import Part
from grader.engine.rubric import load, shipped
from grader.labs.imu import bundles
from grader.labs.imu.answers import FilterRun, NoiseRun, Readings
from grader.labs.imu.collection import Collection
from grader.labs.imu.lab import LAB
from grader.labs.imu.student import FilterCase, Student
from grader.platforms import registry
from grader.platforms.platform import Platform
from grader.report import explanations
from grader.sandbox import surroundings
from grader.sandbox.isolation_levels import LEVELS

FOLDER = Path(__file__).resolve().parent
_PART = re.compile(r"<!-- generated: ([\w-]+) -->(.*?)<!-- end: \1 -->", re.DOTALL)


def _one_of(parts: Iterable[Part]) -> str:
    *first, last = (f"`{part.id}`" for part in parts)
    return f"{', '.join(first)} or {last}"


RUBRIC_KEYS = {
    "criteria": "The five criteria of the lab sheet, each once, in any order.",
    "criteria.id": f"{_one_of(LAB.parts)}.",
    "criteria.title": "The name in reports and gradebooks.",
    "criteria.points": "Points of the criterion: 0 to 1000, at most two decimals.",
    "criteria.checks": "One line `name: weight` for each check. The points of the criterion are shared by weight.",
    "extra_credit": "What extensions earn beside the score. Default: nothing.",
    "extra_credit.each": "Points of each extension that has no points of its own.",
    "extra_credit.cap": "Maximum of all extensions together. Default: their sum.",
    "extensions": "The four extensions of the lab sheet, each once.",
    "extensions.id": f"{_one_of(LAB.bonuses)}.",
    "extensions.title": "The name in reports.",
    "extensions.file": "The file that must define the extension.",
    "extensions.points": "0: reported, but not counted. Above 0: extra credit.",
    "extensions.checks": "One line `name: weight` for each check.",
    "faults": "One line `fault: points` for each fault with a deduction of your own. It counts once in its criterion.",
    "limits": "Limits on the CPU time of student code.",
    "limits.call_cpu_s": "Seconds for one call.",
    "limits.submission_cpu_s": "Seconds for all calls of one submission.",
    "late": "The late policy. Default: none.",
    "late.due": "Due date and time, with the offset from UTC.",
    "late.grace_minutes": "Minutes after `due` that do not count as late. After them, days count from `due`.",
    "late.per_day": "Deduction for each started day: points, or a percentage of the criteria's points.",
    "late.cut_off_days": "Days after which a submission gets 0. Default: no limit.",
    "late.tz": "Time zone whose clock counts the days, for example `Europe/Berlin`. Default: a day has 24 hours.",
    "late.due_dates": "Personal due dates: one line `who: date`. `who` is an id, a name or an e-mail address.",
    "repairs": "Repairs of files that do not run. Default: a person decides on each.",
    "repairs.apply": "`suggested`: `grade` applies an edit of one place if all edits that run earn the same grade. `none`: never.",
    "repairs.deduct": "Deduction for each repair, in points. The review desk proposes it.",
    "model": "The robot that is simulated. Default: the humanoid of the lab.",
    "model.path": "An MJCF file, relative to the rubric. Default: the model of the lab.",
    "model.sensors": "The two sensors of the IMU.",
    "model.sensors.accelerometer": "Name of the accelerometer. Default: `torso_accelerometer`.",
    "model.sensors.gyroscope": "Name of the gyroscope. Default: `torso_gyroscope`.",
}


def filled(page: Path) -> str:
    """Return the text of a page, its generated parts as the code has them now."""
    return fill((FOLDER / page).read_text(encoding="utf-8"))


def fill(text: str) -> str:
    """Replace the text between each pair of marks of a page by the part that they name, as the code has it now."""

    def filled(part: re.Match[str]) -> str:
        name, around = part[1], "\n\n" if "\n" in part[2] else ""
        return f"<!-- generated: {name} -->{around}{PARTS[name]().strip()}{around}<!-- end: {name} -->"

    return _PART.sub(filled, text)


def pages() -> dict[Path, str]:
    """Return the text of every page by its path within the documentation."""
    found = sorted(FOLDER.rglob("*.md"))
    return {path.relative_to(FOLDER): path.read_text(encoding="utf-8") for path in found}


# --- the rubric, its checks and faults --------------------------------------------------------------------------------


def checks() -> str:
    """Return a table of checks for each criterion and extension."""
    return "\n".join(explanations.criterion(LAB, part, level=2) for part in load(LAB).parts)


def faults() -> str:
    """Return every named fault, by criterion."""
    sections = []
    for group, title in explanations.groups(LAB).items():
        found = [each for each in catalogue(LAB).values() if each.group == group]
        sections += [f"## {title}\n", *(explanations.fault(LAB, each, level=3) for each in found)]
    return "\n".join(sections)


def rubric_keys() -> str:
    """Return the table of the rubric's keys."""
    return _table(("Key", "Meaning"), ((f"`{key}`", meaning) for key, meaning in RUBRIC_KEYS.items()))


def rubric() -> str:
    """Return the shipped rubric."""
    return f"```yaml\n{shipped(LAB).read_text(encoding='utf-8').strip()}\n```"


# --- commands ---------------------------------------------------------------------------------------------------------


def commands() -> str:
    """Return every command with its arguments, options and examples."""
    return "\n".join(_commands("imugrade", cli.command()))


def _commands(prefix: str, group: Any) -> Iterator[str]:
    for name, command in sorted(group.commands.items()):
        if hasattr(command, "commands"):
            yield from _commands(f"{prefix} {name}", command)
        elif not command.hidden:
            yield _command(f"{prefix} {name}", command)


def _command(name: str, command: Any) -> str:
    shown = [each for each in command.params if not getattr(each, "hidden", False) and each.name != "help"]
    arguments = [each.metavar for each in shown if each.param_type_name == "argument"]
    table = _table(("Argument or option", "Meaning"), ((_words(each), each.help or "") for each in shown))
    blocks = "\n\n".join(_block(block) for block in command.help.strip().split("\n\n"))
    return f"## `{' '.join([name, *arguments])}`\n\n{blocks}\n\n{table if shown else ''}\n"


def _words(parameter: Any) -> str:
    if parameter.param_type_name == "argument":
        return f"`{parameter.metavar}`"
    metavar = f" {parameter.metavar}" if parameter.metavar else ""
    return ", ".join(f"`{word}{metavar}`" for word in parameter.opts)


def _block(block: str) -> str:
    """Return one paragraph of a help text; one that keeps its lines becomes a code block."""
    lines = [line for line in block.split("\n") if line.strip() != "\b"]
    if len(lines) == len(block.split("\n")):
        return " ".join(line.strip() for line in lines)
    return "\n".join(["```text", *lines, "```"])


# --- platforms --------------------------------------------------------------------------------------------------------


def ci_platforms() -> str:
    """Return the table of CI formats, then a section for each."""
    rows, sections = [], []
    for each in registry.platforms("respond"):
        submission = f"`/{each.submission}`" if each.submission else "working folder"
        answer = f"`{'/' * ('/' in each.answer)}{each.answer}`" if each.answer else "standard output"
        hidden = "with `--traces`" if each.keeps_secrets else "refused without `--private`"
        rows.append((f"`{each.name}`", each.title, submission, answer, hidden))
        sections.append(f"## {each.title}\n\n{each.help.respond}")
    table = _table(("`--format`", "Platform", "Submission", "Output", "Hidden scenarios"), rows)
    return "\n\n".join([table, *sections])


def downloads() -> str:
    """Return the table of downloads that `grade` recognises."""
    rows = [("Folders and archives, one per student", "nothing else fits", "the name of the folder or archive")]
    for each in registry.platforms("read"):
        what, sign, student = each.help.read
        rows.append((", ".join(filter(None, (each.title, what))), sign, student))
    return _table(("Download", "Recognized by", "Student"), rows)


def gradebooks() -> str:
    """Return one paragraph for each gradebook that `export` writes."""
    ways = ((each.title, each.help.grades) for each in registry.platforms("fill", "write"))
    return "\n".join(f"- **{title}**: {text}".replace("\n", "\n  ") for title, text in ways)


def platform_fields() -> str:
    """Return the fields of a platform's record, as its docstring has them."""
    _, text = inspect.cleandoc(Platform.__doc__ or "").split("Attributes\n----------\n")
    fields = re.findall(r"^(\S.*)\n((?: {4}.*\n?)+)", text, re.MULTILINE)
    return _table(("Field", "Meaning"), ((_code(names.split(", ")), " ".join(its.split())) for names, its in fields))


# --- isolation --------------------------------------------------------------------------------------------------------


def isolation_levels() -> str:
    """Return the table of isolation levels."""
    return _table(("Level", "What it uses", "Needs"), ((f"`{each.name}`", each.around, each.needs) for each in LEVELS))


def attacks() -> str:
    """Return how many hostile submissions were held, when and where; `python -m tests.hostile --write` records it."""
    entries = json.loads((FOLDER / "isolation.json").read_text(encoding="utf-8"))
    dates, systems, pythons = (
        enumerated(sorted({each[key] for each in entries})) for key in ("date", "system", "python")
    )
    held: dict[tuple[str, str], list[str]] = {}
    for each in entries:
        row = held.setdefault((f"`{each['isolation_level']}`", each["user"]), [])
        row.append(f"{each['held']} of {each['programs']}")
    families = dict.fromkeys(each["family"] for each in entries)
    table = _table(("Level", "User", *families), ((*run, *row) for run, row in held.items()))
    return f"Attacks held, of those tried, on {dates} ({systems}, Python {pythons}):\n\n{table}"


def libraries() -> str:
    """Return the packages that student code may import."""
    return _code(LAB.packages)


def library_folders() -> str:
    """Return the folders of the system's shared libraries, which student code may read."""
    return _code(surroundings.LIBRARIES)


def system_files() -> str:
    """Return the system files that student code may read."""
    return _code(surroundings.SYSTEM)


# --- agreement with markers -------------------------------------------------------------------------------------------


def agreement() -> str:
    """Return how far the grader is from two independent marks of twenty submissions; `python -m tests.regenerate` measures it."""
    return (
        (FOLDER.parent / "tests" / "corpus" / "calibration" / "agreement.txt").read_text(encoding="utf-8").rstrip("\n")
    )


# --- values that count as numbers --------------------------------------------------------------------------------------


def kinds_of_values() -> str:
    """Return what each kind of values counts as in each question, as the worker's code answers it."""
    from tests.judging import test_kinds_of_numbers as kinds  # noqa: PLC0415 - the documentation is built without the tests

    rows = ((name, *kinds.outcomes(name).values()) for name in kinds.KINDS)
    return _table(("Your function returns", *(f"`{question}`" for question in kinds.QUESTIONS)), rows)


# --- what programs and own checks use ---------------------------------------------------------------------------------

_ASKED = (Student.read, Student.simulate, Student.noise, Student.filter)
_RECORDS = (FilterCase, Readings, Collection, NoiseRun, FilterRun, StudentError, Size)


def result_json() -> str:
    """Return the table of the fields of `result.json`, from its schema."""
    schema = json.loads((Path(results.__file__).parent / "result.schema.json").read_text(encoding="utf-8"))
    return _table(("Field", "Value", "Meaning"), _fields(schema, schema["$defs"], ""))


def _fields(node: Any, known: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, str, str]]:
    for name, given in node["properties"].items():
        field = _resolved(given, known)
        inner = _resolved(field.get("items", {}), known)
        path = f"{prefix}{name}{'[]' if inner.get('properties') else ''}"
        optional = "" if name in node.get("required", ()) else "Optional. "
        yield f"`{path}`", _value(field, known), optional + field.get("description", "")
        for each in (field, inner, *field.get("anyOf", ())):
            if "properties" in each:
                yield from _fields(each, known, f"{path}.")


def _resolved(node: Mapping[str, Any], known: Mapping[str, Any]) -> dict[str, Any]:
    """Return a node of the schema with the definition that it refers to."""
    named = known[node["$ref"].rpartition("/")[2]] if "$ref" in node else {}
    return {**named, **node}


def _value(field: Mapping[str, Any], known: Mapping[str, Any]) -> str:
    if "anyOf" in field:
        return " or ".join(_value(_resolved(each, known), known) for each in field["anyOf"])
    if "enum" in field or "const" in field:
        return ", ".join(f"`{json.dumps(each)}`" for each in field.get("enum", [field.get("const")]))
    inner = _resolved(field.get("items", {}), known).get("type", "")
    return f"array of {inner}s" if field["type"] == "array" else str(field["type"])


def questions() -> str:
    """Return what a check of an instructor's own may ask the student's code: each method with its parameters."""
    return "\n\n".join(_definition(f"student.{each.__name__}", each) for each in _ASKED)


def answers() -> str:
    """Return the records that those methods take and return, with their fields."""
    return "\n\n".join(_definition(each.__name__, each) for each in _RECORDS)


def outcomes() -> str:
    """Return what ends a check of an instructor's own with fewer points."""
    return "\n\n".join(_definition(each.__name__, each) for each in (CheckFailed, raised))


def _definition(name: str, of: Any) -> str:
    """Return a heading, the signature and the docstring of a class or a function."""
    parameters = [each for each in inspect.signature(of).parameters.values() if each.name != "self"]
    shown = "".join(
        f"    {each.name}: {each.annotation}{'' if each.default is each.empty else f' = {each.default!r}'},\n"
        for each in parameters
    )
    returns = inspect.signature(of).return_annotation
    arrow = "" if returns in (inspect.Signature.empty, None, "None") else f" -> {returns}"
    words = (
        inspect.cleandoc(of.__doc__ or "")
        .replace("Attributes\n----------\n", "")
        .replace("Parameters\n----------\n", "")
    )
    first, _, rest = words.partition("\n\n")
    more = "\n".join(f"- {line}" if re.match(r"\w[\w, ]* : ", line) else line for line in rest.split("\n"))
    return f"### `{name}`\n\n{first}\n\n```text\n{name}(\n{shown}){arrow}\n```\n\n{more}".rstrip()


def public_traces() -> str:
    """Return the table of the public scenarios and the arrays of each."""
    rows = []
    for name, scenario in bundles.shipped().scenarios.items():
        rows.append((f"`{name}`", ", ".join(f"`{key}` {array.shape}" for key, array in scenario.items())))
    return _table(("Scenario", "Arrays and shapes"), rows)


# --- the code ---------------------------------------------------------------------------------------------------------


def modules() -> str:
    """Return the table of modules with the first sentence of each docstring."""
    package = Path(cli.__file__).parent
    rows = []
    for path in sorted(package.rglob("*.py")):
        inside = path.relative_to(package.parent)
        if text := ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))):
            name = inside.parent if inside.name == "__init__.py" else inside
            rows.append((f"`{name.as_posix()}`", " ".join(text.split("\n\n")[0].split()).replace("|", "\\|")))
    return _table(("Module", "Purpose"), rows)


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def _code(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


PARTS: Mapping[str, Callable[[], str]] = {
    function.__name__.replace("_", "-"): function
    for function in (
        agreement, answers, attacks, checks, ci_platforms, commands, downloads, faults, gradebooks, isolation_levels,
        kinds_of_values, libraries, library_folders, modules, outcomes, platform_fields, public_traces, questions, result_json,
        rubric, rubric_keys, system_files,
    )
}  # fmt: skip
"""The parts by the name that a page gives."""
