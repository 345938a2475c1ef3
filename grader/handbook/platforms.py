"""What the handbook tells of the platforms: tables and sections, each from the platform's own record."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

from grader.platforms import registry
from grader.platforms.platform import Platform

FOLDER = Path(__file__).parent


def page() -> str:
    """The page of the platforms that take a job's answer."""
    rows = ["| `--format` | Platform | Submission | Answer | Hidden scenarios |", "| --- | --- | --- | --- | --- |"]
    sections = []
    for each in registry.platforms("respond"):
        submission = f"`/{each.submission}`" if each.submission else "working folder"
        answer = f"`{'/' * ('/' in each.answer)}{each.answer}`" if each.answer else "standard output"
        rows.append(f"| `{each.name}` | {each.title} | {submission} | {answer} | {_secrets(each.keeps_secrets)} |")
        sections.append(f"## {each.title}\n\n{each.help.respond}")
    return _filled("platforms.txt", table="\n".join(rows), sections="\n\n".join(sections))


def classes() -> str:
    """The page of a class, with what its downloads are recognised by and how its grades get back."""
    rows = [
        "| Download | Recognised by | A student is |",
        "| --- | --- | --- |",
        "| folders and archives, one a student | nothing else fits | the name of the folder or archive |",
    ]
    for each in registry.platforms("read"):
        what, sign, student = each.help.read
        rows.append(f"| {', '.join(filter(None, (each.title, what)))} | {sign} | {student} |")
    ways = [f"- **{each.title}**: {_indented(each.help.grades)}" for each in registry.platforms("fill", "write")]
    return _filled("classes.txt", downloads="\n".join(rows), grades="\n".join(ways))


def contributing() -> str:
    """How to add one, with the fields of the record as it tells of them itself."""
    _, told = inspect.cleandoc(Platform.__doc__ or "").split("Attributes\n----------\n")
    fields = re.findall(r"^(\S.*)\n((?: {4}.*\n?)+)", told, re.MULTILINE)
    rows = [f"| {_code(names)} | {' '.join(text.split())} |" for names, text in fields]
    return _filled("contributing.txt", fields="\n".join(["| Field | Holds |", "| --- | --- |", *rows]))


def _code(names: str) -> str:
    return ", ".join(f"`{name}`" for name in names.split(", "))


def _filled(name: str, **parts: str) -> str:
    text = (FOLDER / name).read_text(encoding="utf-8")
    for part, made in parts.items():
        text = text.replace(f"{{{part}}}", made)
    return text


def _indented(text: str) -> str:
    return text.replace("\n", "\n  ")


def _secrets(kept: bool) -> str:
    return "with `--traces`" if kept else "refused: students can read what the job reads"
