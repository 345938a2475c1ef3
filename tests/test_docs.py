"""Tests of the documentation: it builds without a warning, its examples work, and the names in it exist."""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml

from docs import generated
from grader import cli
from grader.course.markers import pool
from grader.course.run import classroom
from grader.engine import rubric, rubric_nodes, session
from grader.labs.imu.lab import LAB
from grader.sandbox import limits
from tests.documents import ROOT, commands, documents, site
from tests.hostile.corpus import PROGRAMS

PAGES = site()
HAND_WRITTEN = sorted(page for page in PAGES if not page.startswith("reference/") and not page.endswith("index.md"))
YAML = [(page, text) for page in HAND_WRITTEN for text in re.findall(r"```yaml\n(.*?)```", PAGES[page], re.DOTALL)]


def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", tmp_path / "cache"]
    environment = {**os.environ, "PYTHONWARNINGS": "default"}
    done = subprocess.run(
        [*command, ROOT / "docs", tmp_path / "site"], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    pages = {path.relative_to(tmp_path / "site").with_suffix(".md") for path in (tmp_path / "site").rglob("*.html")}
    assert {Path(page) for page in PAGES} <= pages
    assert (tmp_path / "site" / "searchindex.js").is_file()
    assert 'href="../security.html"' in (tmp_path / "site/administrators/isolation.html").read_text(encoding="utf-8")
    assert "What is promised" in (tmp_path / "site/security.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(("page", "text"), YAML, ids=[page for page, _ in YAML])
def test_every_yaml_example_is_part_of_a_rubric(page: str, text: str, tmp_path: Path) -> None:
    shipped = yaml.safe_load(rubric.shipped(LAB).read_text(encoding="utf-8"))
    example = yaml.safe_load(text)
    for given in example.get("criteria", []):
        (own,) = (each for each in shipped["criteria"] if each["id"] == given["id"])
        own.update(given)
    if path := example.get("model", {}).get("path"):
        accelerometer, gyroscope = example["model"]["sensors"].values()
        (tmp_path / path).write_text(
            '<mujoco><worldbody><body pos="0 0 1"><freejoint/><geom size=".1"/><site name="imu"/></body></worldbody>'
            f'<sensor><accelerometer name="{accelerometer}" site="imu"/><gyro name="{gyroscope}" site="imu"/></sensor></mujoco>'
        )
    merged = {**shipped, **{key: value for key, value in example.items() if key != "criteria"}}
    (tmp_path / "rubric.yaml").write_text(yaml.safe_dump(merged), encoding="utf-8")
    loaded = rubric.load(LAB, tmp_path / "rubric.yaml")
    assert loaded.sha256 != rubric.load(LAB).sha256 or example.items() <= shipped.items()


def test_every_command_has_an_example_in_the_documents() -> None:
    named = {command.words[1] for command in commands(documents()) if command.words[0] == "imugrade"}
    headings = re.findall(r"^## `imugrade (\w+)", generated.commands(), re.MULTILINE)
    assert set(headings) <= named


def test_names_of_tests_and_files_exist() -> None:
    text = "\n".join(documents().values())
    tests = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("test_*.py"))
    files = {path.stem for path in (ROOT / "tests").rglob("test_*.py")}
    assert [
        name for name in re.findall(r"`(test_\w+)`", text) if f"def {name}(" not in tests and name not in files
    ] == []
    paths = re.findall(r"`((?:grader|tests|docs|reference)/[\w/.-]+)`", text)
    assert [path for path in paths if not (ROOT / path).exists()] == []


SYMPTOMS = """
imugrade: command not found | error: externally-managed-environment | No module named venv, or ensurepip is not available
requires a different Python, or Requires-Python >=3.10 | Could not find a version that satisfies the requirement mujoco | No module named 'mujoco' | ParseXML: Error opening file
Invalid wheel filename, is not a valid wheel filename, or the file does not exist | SyntaxError, IndentationError, TabError | No module named 'pandas'
The truth value of an array with more than one element is ambiguous | No points for a picture that looks right
94 at home and 80 from the instructor | 100 at home, and the platform says something else | I think that the grader is wrong
imugrade is already installed with the same version | doctor says landlock | The address of the desk opens nothing
A student says: 94 at home and 80 here | A student says: the grader is wrong | It takes very long | No space left on device
A package that submissions import is missing | Which version graded this? | doctor says landlock, bubblewrap or none
The platform gives everybody the same | Killed, or this machine ran out of memory | Imports go down BROKEN
"""
"""Headings of the pages on messages that are no text of imugrade: what other programs say, and what people see."""
EXAMPLE_VALUES = r"NotImplementedError: |^breakpoint|^points must be |^--format canvas |filters\.py|LowPassFilter|get_imu_readings|alice|starlette|Lab 04-01|tcp://…|…|mujoco [\d.]+|\d+(?:\.\d+)+|\d+"


def texts_below(folder: str) -> str:
    """Return the files of a folder as one line, in which a text that is written in several lines is whole; of tests the strings."""
    suffixes = (".py",) if folder == "tests" else (".py", ".j2", ".yaml", ".txt")
    source = [path.read_text(encoding="utf-8") for path in (ROOT / folder).rglob("*") if path.suffix in suffixes]
    if folder == "tests":  # no comments, and no docstrings, which nobody sees
        nodes = [node for text in source for node in ast.walk(ast.parse(text))]
        unseen = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        source = [str(node.value) for node in nodes if isinstance(node, ast.Constant) and id(node) not in unseen]
    return " ".join(re.sub(r'"\s*\n\s*f?"', "", "\n".join(source)).split())


def test_a_heading_of_the_pages_on_messages_is_a_text_of_the_product_or_for_contributors_of_the_tests() -> None:
    product, tests = texts_below("grader"), texts_below("tests")
    known = {each.strip() for each in re.split(r"[|\n]", SYMPTOMS)} - {""}
    headings = {
        title: tests if page.startswith("contributors/") else product
        for page in PAGES
        if page.endswith("/trouble.md")
        for title in re.findall(r"^## (.*)$", PAGES[page], re.M)
    }
    pieces = {title: re.split(EXAMPLE_VALUES, title) for title in headings.keys() - known}
    assert {part for title, parts in pieces.items() for part in parts if part.strip() not in headings[title]} == set()
    assert known - headings.keys() == set()


REPOSITORY_PAGES = sorted(path for path in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])


def anchors(page: Path) -> set[str]:
    """Return the anchors that a repository's web page and the site give to the headings of a page."""
    prose = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    titles = re.findall(r"^#+ (.*)$", prose, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", REPOSITORY_PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_link_of_a_page_leads_to_a_file_and_a_heading(page: Path) -> None:
    prose = re.sub(r"^```.*?^```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    found = re.findall(r"\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"", prose)
    links = [link.partition("#") for pair in found for link in pair if link and not link.startswith("http")]
    broken = []
    for path, _, anchor in links:
        target = page.parent / path if path else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            broken.append(f"{path}#{anchor}")
    assert broken == []


@pytest.mark.parametrize("page", PAGES)
def test_generated_parts_of_the_pages_are_those_of_the_code(page: str) -> None:
    assert PAGES[page].count("<!-- generated: ") == PAGES[page].count("<!-- end: ")
    assert generated.fill(PAGES[page]) == PAGES[page], "run python -m tests.regenerate docs"


def test_the_results_of_the_attacks_count_every_attack_on_each_level() -> None:
    counted: dict[tuple[str, str], dict[str, int]] = {}
    for each in json.loads((ROOT / "docs" / "isolation.json").read_text(encoding="utf-8")):
        counted.setdefault((each["isolation_level"], each["user"]), {})[each["family"]] = each["programs"]
    families = Counter(program.family for program in PROGRAMS)
    assert [run for run, of in counted.items() if of != families] == [], "run python -m tests.hostile --write"


def test_the_worst_case_of_a_job_follows_from_the_limits_of_the_code() -> None:
    of_student_code, of_job = limits.MEMORY_BYTES >> 30, pool.Bounds().memory_bytes >> 30
    cpu_s = rubric.load(LAB).limits.submission_cpu_s
    waits, stands = session._WALL_PER_CPU * cpu_s / 60, pool.ATTEMPTS * classroom._WALL_PER_CPU * cpu_s / 60
    worst = f"{of_job + 2 * of_student_code} GB ({of_job + of_student_code} GB on public scenarios)"
    page = PAGES["administrators/cost.md"]
    assert f"{worst}, {cpu_s / 60:g} minutes of CPU, {waits:g} minutes if its code waits |" in page
    assert f"{pool.ATTEMPTS} attempts: {stands:g} minutes" in page.replace("two", "2")
    assert f"for {cpu_s / 60:g} to {waits:g}\nminutes" in page
    assert f"[{cpu_s / 60:g} to {waits:g} minutes](cost.md)" in PAGES["administrators/ci.md"]


def test_every_field_of_result_json_has_a_meaning() -> None:
    assert re.findall(r"^\| `(\S+)` \| .* \| (?:Optional\. )? *\|$", generated.result_json(), re.MULTILINE) == []


def test_every_page_of_a_folder_is_in_its_list() -> None:
    for index in (ROOT / "docs").glob("*/index.md"):
        listed = re.findall(r"^- \[[^]]+\]\(([\w-]+\.md)\): \S", index.read_text(encoding="utf-8"), re.MULTILINE)
        assert sorted(listed) == sorted(each.name for each in index.parent.glob("*.md") if each != index)


EVERY_SECTION = """
extra_credit: {each: 5}
late: {due: 2026-11-20T23:59+01:00}
repairs: {apply: none, deduct: 5}
faults: {no-bias: 1}
"""


def test_the_keys_that_the_rubric_has_are_those_that_are_documented(monkeypatch: pytest.MonkeyPatch) -> None:
    above = {
        "the rubric": "",
        "this criterion": "criteria.",
        "this extension": "extensions.",
        "sensors": "model.sensors.",
    }
    found: set[str] = set()
    fields = rubric_nodes.NodeReader.fields

    def noting(reader: Any, node: Any, what: str, required: Sequence[str], optional: Sequence[str] = ()) -> Any:
        found.update(above.get(what, f"{what}.") + key for key in (*required, *optional))
        return fields(reader, node, what, required, optional)

    monkeypatch.setattr(rubric_nodes.NodeReader, "fields", noting)
    whole = rubric.shipped(LAB).read_bytes() + EVERY_SECTION.encode()
    rubric.parse(LAB, whole)
    assert {key for key in found if "." not in key} == yaml.safe_load(whole).keys(), "a section lacks in EVERY_SECTION"
    assert found == set(generated.RUBRIC_KEYS)


MADE_UP = {"filtering.settles_after_a_step", "filtering.takes_alpha_one"}
"""Checks that two pages write as an example."""


def test_every_check_that_a_page_or_a_help_names_exists() -> None:
    parts = "|".join(part.id for part in rubric.load(LAB).parts)
    named = re.compile(rf"(?<![\w./])(?:{parts})\.(?!py\b|yaml\b|filter_cases\b)[a-z]\w+")
    known = {check.id for check in rubric.load(LAB).checks} | MADE_UP
    texts = {**documents(), "the shipped rubric": rubric.shipped(LAB).read_text(encoding="utf-8")}
    assert [(name, each) for name, text in texts.items() for each in named.findall(text) if each not in known] == []


def test_every_sentence_on_a_grade_that_a_command_changes_stands_in_its_help(
    capsys: pytest.CaptureFixture[str],
) -> None:
    page = (ROOT / "docs" / "instructors" / "regrade.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(grade|adjust|repair|export)` \|.* \| (.*) \|$", page, re.MULTILINE)
    assert len(rows) >= 15
    for command, sentence in rows:
        assert cli.main([command, "--help"]) == 0
        assert sentence in " ".join(capsys.readouterr().out.split())
