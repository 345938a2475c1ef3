"""The handbook is what the code says today, and what it names exists."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from grader import cli
from grader.engine.mistakes import catalogue
from grader.engine.rubric import load, shipped
from grader.handbook import flow, pages, rubric_keys
from grader.labs.imu.lab import LAB
from grader.platforms import registry
from tests.documents import handbook
from tests.generated import STALE

SVG = "{http://www.w3.org/2000/svg}"
MADE = handbook()


@pytest.mark.parametrize("name", sorted(MADE))
def test_each_page_is_current(name: str) -> None:
    kept = (pages.FOLDER / name).read_text(encoding="utf-8")
    assert kept == MADE[name], f"{name}: {STALE}"


def test_no_page_is_left_over() -> None:
    assert {path.name for path in pages.FOLDER.iterdir() if path.suffix in (".md", ".svg")} == set(MADE)


def test_every_link_leads_to_a_page() -> None:
    for name, text in MADE.items():
        for target in re.findall(r"\]\(([^)]+)\)", text) if name.endswith(".md") else []:
            assert target in MADE or (pages.FOLDER / target).is_file(), f"{name} links to {target}"


def test_every_mistake_check_and_format_stands_in_its_page() -> None:
    assert [id_ for id_ in catalogue(LAB) if f"### {id_}\n" not in MADE["mistakes.md"]] == []
    assert [c.id for c in load(LAB).checks if f"| `{c.id.partition('.')[2]}` |" not in MADE["checks.md"]] == []
    assert [name for name in registry.names("respond") if f"| `{name}` |" not in MADE["platforms.md"]] == []


def keys(node: object, prefix: str = "") -> set[str]:
    """The keys of the shipped rubric, with dots; the names of checks are not keys."""
    if isinstance(node, list):
        return set().union(*(keys(item, prefix) for item in node))
    if not isinstance(node, dict) or prefix.endswith("checks."):
        return set()
    return {prefix + key for key in node} | set().union(
        *(keys(value, f"{prefix}{key}.") for key, value in node.items())
    )


def test_every_key_of_the_rubric_is_told() -> None:
    used = keys(yaml.safe_load(shipped(LAB).read_text(encoding="utf-8")))
    assert used - set(rubric_keys.KEYS) == set()
    left_out = {
        key for key in set(rubric_keys.KEYS) - used if key.partition(".")[0] not in ("late", "extra_credit", "mistakes")
    }
    assert left_out <= {"model.path", "extensions.points"}  # these may be left out


def test_the_picture_is_whole_and_no_text_runs_out_of_its_box() -> None:
    root = ElementTree.fromstring(flow.picture())
    widths = {(box.get("x"), box.get("y")): int(box.get("width", 0)) for box in root.iter(f"{SVG}rect")}
    assert len(widths) == 11
    for text in root.iter(f"{SVG}text"):
        x, y, small = int(text.get("x", 0)), int(text.get("y", 0)), text.get("class") == "small"
        room = widths[(str(x - 14), str(y - (47 if small else 27)))]
        assert len(text.text or "") * (6.7 if small else 8.5) <= room - 20, text.text


def test_the_pages_ship_inside_the_package() -> None:
    assert Path(cli.__file__).parent / "handbook" == pages.FOLDER
