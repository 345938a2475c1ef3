"""Checks of an instructor's own, in the folder `checks` beside `rubric.yaml`."""

from __future__ import annotations

import io
import pickle
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from grader.base.errors import RequestError
from grader.engine import rubric
from grader.engine.check_runner import known_checks
from grader.engine.results import CheckResult
from grader.engine.rubric import Rubric
from grader.kit import wheel
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.class_commands import rubric_with
from tests.corpus.pieces import FILTERS, part
from tests.sandboxes import Opened
from tests.single_faults import marked

PAGE = (Path(__file__).parent.parent / "docs/instructors/own-checks.md").read_text(encoding="utf-8")
(EXAMPLE,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
(LINE,) = re.findall(r"\n( +settles_after_a_step: 4)\n", PAGE)
ID = "filtering.settles_after_a_step"

Own = Callable[..., Path]


@pytest.fixture
def own(tmp_path: Path) -> Own:
    """A rubric with the documentation's line in it, and a folder of checks beside it."""

    def write(**checks: str) -> Path:
        (tmp_path / "checks").mkdir(exist_ok=True)
        for name, source in checks.items():
            (tmp_path / "checks" / f"{name}.py").write_text(source)
        return rubric_with(tmp_path / "rubric.yaml", ("instances_independent: 3", f"instances_independent: 3\n{LINE}"))

    return write


def judged(opened: Opened, its_rubric: Rubric, source: str) -> CheckResult:
    with opened(bundles.obtain(LAB, None), its_rubric) as marker:
        (criterion,) = marked(marker, {"filters.py": source}, "filtering").criteria
    return next(check for check in criterion.checks if check.id == ID)


def test_the_documented_own_check_is_earned_by_the_sheets_filter_and_lost_by_another(opened: Opened, own: Own) -> None:
    its_rubric = pickle.loads(pickle.dumps(rubric.load(LAB, own(check_step=EXAMPLE))))  # as it comes to another machine
    assert {each.id: each.max_points for each in its_rubric.checks}[ID] == 3.33
    earned = judged(opened, its_rubric, FILTERS)
    assert (earned.outcome, earned.points) == ("passed", 3.33)
    too_low = part("steps", "filter").replace("self.alpha * measurement", "0.9 * self.alpha * measurement")
    slow = judged(opened, its_rubric, too_low)
    assert (slow.outcome, slow.points) == ("failed", 0.0)
    assert slow.message.startswith("Expected  less than 0.02 m/s² from the step's height")
    assert slow.hint.startswith("alpha is the weight of the measurement")


def test_a_check_without_a_weight_and_a_weight_without_a_check_are_told(own: Own) -> None:
    its_rubric = rubric.load(LAB, own())
    with pytest.raises(RequestError, match=r"there is no check filtering\.settles_after_a_step"):
        rubric.match_checks(its_rubric, {id_: each.title for id_, each in known_checks(LAB).items()})


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("boo", "check_step.py: NameError: name 'boo' is not defined"),
        ("def f(:\n", "check_step.py: SyntaxError: invalid syntax"),
        ("def check_x(student): ...\n", "check_step.py: check_x is no check: write @check(...) above it"),
        (EXAMPLE.replace(ID, "filtering.reduces_noise"), "there are 2 checks filtering.reduces_noise"),
    ],
)
def test_a_slip_in_the_folder_is_the_requests_fault_and_named(own: Own, source: str, said: str) -> None:
    checks = rubric.load(LAB, own(check_step=source)).own_checks
    with pytest.raises(RequestError, match=re.escape(f"own checks: {said}")):
        known_checks(LAB, checks)


def test_files_of_one_name_in_two_folders_are_two_checks(own: Own) -> None:
    for said in ("With alpha 0.5", "With alpha 0.6"):
        checks = rubric.load(LAB, own(check_step=EXAMPLE.replace("With alpha 0.5", said))).own_checks
        assert known_checks(LAB, checks)[ID].title.startswith(said)


def test_helpers_beside_a_check_are_found(own: Own) -> None:
    source = EXAMPLE.replace("import numpy as np\n", "import numpy as np\n\nfrom .helping import LIMIT\n")
    checks = rubric.load(LAB, own(check_step=source, helping="LIMIT = 0.02\n")).own_checks
    assert ID in known_checks(LAB, checks)


def test_a_kits_wheel_carries_them(own: Own) -> None:
    with zipfile.ZipFile(io.BytesIO(wheel.build(LAB, own(check_step=EXAMPLE)))) as archive:
        assert archive.read("grader/labs/imu/own_checks/check_step.py").decode() == EXAMPLE
