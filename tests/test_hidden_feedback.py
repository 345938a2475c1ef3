"""Tests that feedback on hidden scenarios holds nothing that code could choose after it has seen hidden data."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from grader.engine import hidden_feedback
from grader.engine.faults import catalogue
from grader.engine.findings import CheckFailed, GraderText, Size
from grader.engine.results import Result, to_dict
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from grader.platforms.gradescope import gradescope
from grader.platforms.prairielearn import prairielearn
from grader.report.pages import report_page
from tests.corpus.pieces import tidy
from tests.sandboxes import Opened
from tests.single_faults import marked

PUBLIC = "`imugrade check` shows the numbers of the public scenarios."
MISTAKES = catalogue(LAB)

# Everything that code can choose says the same: seven digits of a state that it was shown.
TOKEN = """token = str(abs(int(float(data.qpos[7]) * 1e9)))[:7].rjust(7, '7')
    with open(token + '.txt', 'w') as file:
        file.write(token)"""
READER = f"""
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    {TOKEN}
    print(token)
    Odd = type('Error' + token, (ValueError,), {{}})
    exec(compile('\\n' * (int(token) % 90000) + 'raise Odd(token)', token + '.py', 'exec'), {{'Odd': Odd, 'token': token}})
"""
COLLECTOR = f"""
def simulate_and_collect(model, data, duration_seconds=5.0):
    {TOKEN}
    n = int(token) % 5000 + 7
    model.opt.timestep = float('0.00' + token)
    return {{'time' + token: np.arange(n) * float(token), 'acceleration': np.full((n, 3), float(token)), token: np.zeros((n, 3))}}
"""
NOISY = """
class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        self.data = data
    def read(self):
        token = str(abs(int(float(self.data.qpos[7]) * 1e9)))[:7].rjust(7, '7')
        return np.full(3, float(token)), np.full(3, float(token[::-1]))
"""
ENDING = """
import os
class LowPassFilter:
    def __init__(self, alpha=0.1, initial_value=None):
        pass
    def update(self, measurement):
        os._exit(int(abs(measurement[0]) * 1e6) % 200 + 50)
"""
SPY = {
    "imu_reader.py": tidy()["imu_reader.py"] + READER + COLLECTOR,
    "noisy_imu.py": tidy()["noisy_imu.py"] + NOISY,
    "filters.py": tidy()["filters.py"] + ENDING,
}


@pytest.fixture(scope="module")
def results(cache: Path, hidden: Traces, opened: Opened) -> list[Result]:
    """The spy's results under two secrets: whatever differs between them was chosen by the spy, or is hidden itself."""
    found = []
    for truth in (hidden, bundles.obtain(LAB, "another secret", cache)):
        with opened(truth) as marker:
            found.append(marked(marker, SPY))
    return found


def _words(result: Result) -> list[str]:
    checks = [check for part in result.parts for check in part.checks]
    return [text for check in checks for text in (check.id, check.outcome, check.message, check.hint)]


def test_two_secrets_lead_to_the_same_words_and_to_no_place_that_code_chose(results: list[Result]) -> None:
    """Powers of ten apart: an error's size is told, as coarsely as that."""
    first, second = (_words(result) for result in results)
    differ = [(a, b) for a, b in zip(first, second, strict=True) if a != b]
    assert [pair for pair in differ if not all(re.search(" by (1e|0|1)", text) for text in pair)] == []
    assert results[0].notes == results[1].notes
    checks = [check for result in results for part in result.parts for check in part.checks]
    assert "error" in {check.outcome for check in checks}
    assert {check.where for check in checks} == {None}


def test_no_output_holds_a_number_or_a_name_that_the_spy_made(results: list[Result]) -> None:
    """Of our own numbers only powers of ten have as many digits. Notes come from a process with the public robot: see above."""
    for result in (replace(each, notes=()) for each in results):
        told = to_dict(result)
        outputs = [
            *_words(result),
            json.dumps([told["criteria"], told["extensions"], told["misconceptions"]]),
            gradescope(result, hidden=True).split('"extra_data"')[0],
            prairielearn(result),
            report_page(FinalGrade("spy", result)).split("<main", 1)[1].split("Provenance")[0],
        ]
        for text in outputs:
            assert "Error" not in re.sub(r"\b(Value|Type|Key|Index|Name|Attribute)Error\b", "", text)
            plain = re.sub(r'<dd class="mono">[0-9a-f]+</dd>', "", text)  # our own hashes
            assert [digits for digits in re.findall(r"\d{5,}", plain) if set(digits) - {"0", "1"}] == []


STEP = "Hold it against Step 6."


@pytest.mark.quick
@pytest.mark.parametrize(
    ("hint", "mistakes", "said"),
    [
        ("", (), PUBLIC),
        (GraderText(STEP), (), f"{STEP} {PUBLIC}"),
        (STEP, (), PUBLIC),
        (f"{GraderText(STEP)} 1.25", (), PUBLIC),
        (GraderText(STEP) + " 1.25", (), PUBLIC),
        (GraderText(STEP), ("alpha-swapped",), STEP),
        (STEP, ("alpha-swapped",), MISTAKES["alpha-swapped"].hint),
        ("", ("alpha-swapped",), MISTAKES["alpha-swapped"].hint),
    ],
)
def test_a_hint_is_told_where_all_of_it_stands_in_our_code(hint: str, mistakes: tuple[str, ...], said: str) -> None:
    finding = CheckFailed("0.1", "1.25", mistakes=mistakes, hint=hint, off=Size("it is off"))
    assert hidden_feedback.feedback_on(finding, MISTAKES).hint == said
