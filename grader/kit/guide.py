"""The students' guide: the student pages of the documentation and all named faults, as one HTML file that works offline.

Reports name a fault where it explains what the grader found. The guide explains each such fault, and lists all checks.
Students get no repository, because it holds the solution, so the kit brings them these pages.
"""

from __future__ import annotations

import base64
import re
from itertools import pairwise
from pathlib import Path

from jinja2 import Environment, StrictUndefined
from markdown_it import MarkdownIt
from markdown_it.token import Token
from markupsafe import Markup

from grader.base.package_data import beside
from grader.engine.faults import catalogue
from grader.engine.lab import Lab
from grader.engine.rubric import load
from grader.report import explanations

_FAULTS, _CHECKS = "faults", "checks"


def build(lab: Lab, rubric: Path | None = None) -> str:
    """Return the students' guide of a lab as one HTML page, with the points of a rubric (None: the lab's own)."""
    folder = pages(lab)
    index = (folder / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^- \[[^]]+\]\(([\w-]+)\.md\)", index, re.MULTILINE)
    texts = {name: (folder / f"{name}.md").read_text(encoding="utf-8") for name in listed}
    texts |= {_CHECKS: _checks(lab, rubric), _FAULTS: _faults(lab)}
    index += f"- [All checks](../reference/{_CHECKS}.md): what they test, and their points.\n"
    index += f"- [All faults](../reference/{_FAULTS}.md): each with wrong and right code.\n"
    sections = {name: Markup(_html(text, name, folder)) for name, text in {"index": index, **texts}.items()}
    template = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    text = beside(__package__, "students/guide.html.j2").read_text(encoding="utf-8")
    return template.from_string(text).render(lab=lab.label, sections=sections)


def pages(lab: Lab) -> Path:
    """Return the folder of the Markdown pages of the guide: in the lab's folder if installed, else `docs/students`."""
    built = lab.folder / "guide"
    return built if built.is_dir() else beside("grader", "").parent / "docs" / "students"


def _checks(lab: Lab, rubric: Path | None) -> str:
    parts = load(lab, rubric).parts
    return "\n".join(["# All checks\n", *(explanations.criterion(lab, part, level=2) for part in parts)])


def _faults(lab: Lab) -> str:
    sections = ["# All faults\n\nA report names a fault if it explains what the grader found.\n"]
    for group, title in explanations.groups(lab).items():
        found = [each for each in catalogue(lab).values() if each.group == group]
        sections += [f"## {title}\n", *(explanations.fault(lab, each, level=3) for each in found)] if found else []
    return "\n".join(sections)


def _html(text: str, page: str, folder: Path) -> str:
    """Return a Markdown page as HTML for the guide: headings get ids, links lead to its sections, pictures are included."""
    markdown = MarkdownIt("commonmark", {"html": True}).enable("table")
    tokens = markdown.parse(re.sub(r"^:::.*\n", "", text, flags=re.MULTILINE))
    for before, token in pairwise(tokens):
        if before.type == "heading_open":
            before.attrs["id"] = page if before.tag == "h1" else f"{page}-{_slug(token.content)}"
        for inner in token.children or ():
            _point(inner, page, folder)
    return str(markdown.renderer.render(tokens, markdown.options, {}))


def _point(token: Token, page: str, folder: Path) -> None:
    """Make a link or a picture refer to a place or to data within the guide's one file; links to web sites stay."""
    if token.type == "image":
        picture = base64.b64encode((folder / str(token.attrs["src"])).read_bytes()).decode()
        token.attrs["src"] = f"data:image/png;base64,{picture}"
    target = str(token.attrs.get("href", ""))
    if token.type == "link_open" and not target.startswith("http"):
        path, _, heading = target.partition("#")
        name = Path(path).stem or page
        token.attrs["href"] = f"#{name}-{heading}" if heading else f"#{name}"


def _slug(title: str) -> str:
    """Return the anchor of a heading, as links in the pages have it for the repository's web view and the documentation's site."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
