"""The main job on real input: the example class goes in by the command, fair marks come out, and the same ones again."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import uvicorn

from grader.engine import rubric
from grader.engine.results import from_dict, to_json
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.class_commands import column, in_process
from tests.examples import FOLDER, expected, folders, summary
from tests.fake_results import without_durations
from tests.generated import STALE
from tests.rubrics import edited
from tests.sandboxes import Opened

SCHEMA = json.loads(
    (Path(__file__).parent.parent / "grader" / "engine" / "result.schema.json").read_text(encoding="utf-8")
)


AGAIN = ("s06-id-as-address", "s11-kills-its-interpreter")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """By the rubric that ships, but for how long a loop without an end is waited for: the delivered tests wait as long as it says."""
    out = tmp_path_factory.mktemp("class") / "out"
    by = out.with_name("rubric.yaml")
    by.write_text(edited("call_cpu_s: 10\n", "call_cpu_s: 1\n"), encoding="utf-8")
    command = [sys.executable, "-m", "grader", "grade", str(FOLDER), "-o", out.name, "--rubric", str(by), "--jobs", "1"]
    run = subprocess.run(command, cwd=out.parent, capture_output=True, text=True, check=False, timeout=600)
    assert run.returncode == 0, run.stdout + run.stderr
    out.with_name("printed.txt").write_text(run.stdout + run.stderr, encoding="utf-8")
    return out


def _record(out: Path, name: str) -> dict[str, Any]:
    record: dict[str, Any] = json.loads((out / "submissions" / name / "result.json").read_text(encoding="utf-8"))
    return record


def test_every_example_gets_what_the_table_says(out: Path) -> None:
    """One test, not one an example: workers share the tests of a module, and each would grade the class."""
    records = {folder.name: _record(out, folder.name) for folder in folders()}
    for record in records.values():
        jsonschema.validate(record, SCHEMA)
    assert {name: summary(from_dict(record)) for name, record in records.items()} == expected(), STALE
    assert column(out / "gradebook.csv", "status").keys() == records.keys()


def test_grading_again_gives_the_same_bytes_but_for_durations(out: Path, opened: Opened) -> None:
    with opened(bundles.shipped(), rubric.load(LAB, out.with_name("rubric.yaml"))) as marker:
        for name in AGAIN:
            first = _record(out, name)
            second = json.loads(to_json(marker.mark(read_submission(FOLDER / name, LAB.files))))
            assert without_durations(first) == without_durations(second)
            assert list(first) == list(second)


def test_the_readme_and_the_tutorial_show_what_their_commands_print(
    out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Hold every block of output that follows a command; `…` in it stands for what the page leaves out."""

    async def leave_at_once(_server: uvicorn.Server) -> None:
        pass

    pages = ("README.md", "docs/instructors/first-class.md")
    text = "\n".join((FOLDER.parent / page).read_text(encoding="utf-8") for page in pages)
    blocks = re.findall(r"```sh\n.*?imugrade (.*)\n```\n\n```text\n([^`]*)```", text)
    assert [words.split()[0] for words, _ in blocks] == ["grade", "grade", "explain", "review", "adjust", "export"]
    shutil.copytree(out.parent, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(uvicorn.Server, "main_loop", leave_at_once)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    for words, shown in blocks:
        if words.startswith("grade "):
            printed = Path("printed.txt").read_text(encoding="utf-8")
        else:
            code, *streams = in_process(capsys)(*shlex.split(words))
            printed = re.sub(r"\x1b\[[\d;]*m", "", "".join(streams))
            assert code == 0, printed
        pattern = re.escape(" ".join(shown.split())).replace("…", ".*")
        assert re.search(pattern, " ".join(printed.split())), printed
