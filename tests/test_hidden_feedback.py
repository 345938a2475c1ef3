"""What a student reads beside hidden scenarios: nothing that their code could choose, and in our words.

Submissions put digits of the hidden robot or of its states into a text, a name, a line, a count or a file name: at import, where a
program goes on below its main guard, or in each answer. Graded under two secrets, everything that a student may read is the same.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from textwrap import indent

import mujoco
import pytest

from grader.engine import hidden_feedback
from grader.engine.faults import catalogue
from grader.engine.findings import CheckFailed, GraderText, Size
from grader.engine.grader import Marker
from grader.engine.results import Result, to_dict
from grader.engine.traces import Traces
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from grader.people.final_grade import FinalGrade
from grader.platforms import registry
from grader.platforms.platform import ResultContext
from grader.report.pages import report_page
from tests.corpus.pieces import MODEL_PATH, edit, tidy
from tests.corpus.writing import notebook
from tests.sandboxes import Opened
from tests.single_faults import marked, submission_of

# `token` holds eight masses of the robot that is graded with, `digit` one digit of them.
SPIES = f"""
import mujoco
_spied = mujoco.MjModel.from_xml_path("{MODEL_PATH}")
token = "X " + " ".join("%.9f" % v for v in _spied.body_mass[1:9])
digit = int(_spied.body_mass[2] * 1e6) % 10
"""
RAISES = "raise ValueError(token)\n"


def added(file: str, *code: str) -> dict[str, str]:
    files = tidy()
    return {**files, file: "\n".join([files.get(file, ""), SPIES, *code])}


def replaced(file: str, old: str, new: str) -> dict[str, str]:
    """The file begins with `SPIES` and has another part."""
    files = edit(tidy(), file, (old, new))
    return {**files, file: f"{SPIES}\n{files[file]}"}


def in_filter_class(code: str) -> dict[str, str]:
    return replaced("filters.py", "class LowPassFilter:\n", f"class LowPassFilter:\n    {code}")


def drawn(part: str, other: str) -> dict[str, str]:
    """The recorder and the plot with another part."""
    return replaced("imu_reader.py", part, other)


LEAKS: Mapping[str | None, Mapping[str, dict[str, str]]] = {
    "noise_model": {
        "message at module level": added("noisy_imu.py", RAISES),
        "type name of an exception": added("noisy_imu.py", "raise type('E' + token.replace(' ', '_').replace('.', '_'), (ValueError,), {})()\n"),
        "type name taken from builtins": added("noisy_imu.py", "raise [KeyError, ValueError, TypeError, OSError, EOFError, LookupError, "
                                               "RuntimeError, IndexError, NameError, MemoryError][digit]()\n"),
        "decorator": replaced("noisy_imu.py", "class NoisyIMU:\n", f"def tells(made):\n    {RAISES}\n@tells\nclass NoisyIMU:\n"),
        "fields of a SyntaxError": added("noisy_imu.py", "raise SyntaxError(token, ('<submission>/noisy_imu.py', digit, digit, token))\n"),
        "line and file of compiled code": added("noisy_imu.py", "exec(compile('\\n' * digit + 'raise OSError', '<submission>/' + token, 'exec'))\n"),
        "how many statements raise": added("noisy_imu.py", *(f"if digit > {n}:\n    raise ValueError" for n in range(9))),
    },
    "filtering": {
        "class body": in_filter_class(RAISES),
        "name of a missing module": in_filter_class("__import__('m' + token)\n"),
        "below the main guard": added("filters.py", f"if __name__ == '__main__':\n    {RAISES}"),
        "which name a file defines": added("filters.py", "globals()['LowPassFilte' + 'rstuvwxyz_'[digit]] = LowPassFilter\ndel LowPassFilter\n"),
        "how it ends": added("filters.py", "import os\nos._exit(digit + 50)\n"),
        "whether a name is there": added("filters.py", "if digit % 2:\n    del LowPassFilter\n"),
    },
    "visualization": {
        "title of a figure": drawn('"Torso accelerometer"', "token"),
        "label of an axis": drawn('"Acceleration [m/s^2]"', "token"),
        "names of curves": drawn('label=f"$a_{axis}$"', "label=token + axis"),
        "text in a figure": drawn("fig.tight_layout()", "fig.text(0.1, 0.5, token)"),
        "name of a picture": drawn('"imu_data.png"', "'imu' + token.replace(' ', '_') + '.png'"),
        "size of a figure": drawn("figsize=(10, 6)", "figsize=(10, 6 + digit / 10)"),
    },
    "allan_variance": {
        "extension's file": {**tidy(), "allan_variance.py": f"{SPIES}\n{RAISES}def allan_deviation(samples, rate):\n    return [], []\n"},
    },
    None: {
        "notebook's cell": {"lab.ipynb": notebook(*tidy().values(), SPIES + RAISES)},
        "which file defines a name": {
            **{path: text for path, text in tidy().items() if path != "filters.py"},
            **{f"part{n}.py": "x = 1\n" for n in range(10)},
            "noisy_imu.py": tidy()["noisy_imu.py"] + SPIES
            + f"open(f'part{{digit}}.py', 'w').write({tidy()['filters.py']!r})\n",
        },
        "keys of a recording": drawn('"acceleration": acceleration', "token: acceleration"),
        "text in place of a recording": drawn('"acceleration": acceleration', '"acceleration": token'),
    },
}  # fmt: skip
"""By the criterion that is graded, which is the one that reads the leak; None where several do."""
_VARIES = re.compile(r""""(traces_sha256|duration_s|execution_time|datetime)": [^,}]*| (time|timestamp)="[^"]*\"""")
"""What tells two bundles or two runs apart in the output of a platform: a digest that every student may know, and times."""
_RUNNER = dict.fromkeys(("CLASSROOM", "ASSIGNMENT", "SUBMISSION_TAG", "COMMIT_URL", "RELEASE_URL", "OWNER"), "x")
"""What a platform asks its runner for."""
_DIGEST = re.compile(r"<dt>Traces</dt><dd[^>]*>\w+</dd>|\d+(\.\d+)? s\b")
DIFFER_IN_A_BIT = {"whether a name is there"}
"""The outcome of a check is told, so code can choose it. These may differ between secrets, in outcomes and our own words."""


@pytest.fixture(scope="module")
def secrets(cache: Path, hidden: Traces) -> tuple[Traces, Traces]:
    """Two secrets under which every `digit` differs."""
    first, second = hidden, bundles.obtain(LAB, "another secret", cache)
    assert _masses(first) != _masses(second)
    return first, second


def _masses(truth: Traces) -> list[float]:
    return list(mujoco.MjModel.from_xml_string(truth.models["lab"]).body_mass)


def outputs(result: Result, files: dict[str, str]) -> dict[str, str]:
    """Everything that a student may read of a result; without what tells the two bundles and the time apart."""
    told = to_dict(result)
    told["provenance"] = {k: v for k, v in told["provenance"].items() if k != "traces_sha256"}
    told["duration_s"] = 0
    handed = ResultContext(LAB, submission_of(files), Path("x"), _RUNNER, hidden=True)
    found = {"result.json": json.dumps(told), "report.html": _DIGEST.sub("", report_page(FinalGrade("x", result)))}
    for platform in registry.platforms("respond"):
        assert platform.respond is not None
        found[platform.name] = _VARIES.sub("", platform.respond(result, handed))
        if platform.aside is not None:
            found[f"{platform.name} aside"] = platform.aside.text(result, handed)
    return found


EVERY_CHANGE = {
    "message at module level", "fields of a SyntaxError", "how many statements raise", "name of a missing module", "whether a name is there",
    "title of a figure", "name of a picture", "extension's file", "which file defines a name", "keys of a recording",
}  # fmt: skip
"""One leak of each way out; the others take the same way, and run each week."""


@pytest.mark.parametrize(
    ("only", "name"),
    [
        pytest.param(only, name, marks=[] if name in EVERY_CHANGE else [pytest.mark.weekly])
        for only, leaks in LEAKS.items()
        for name in leaks
    ],
)
def test_two_secrets_lead_to_the_same_outputs(
    only: str | None, name: str, secrets: tuple[Traces, Traces], opened: Opened
) -> None:
    told, files = [], LEAKS[only][name]
    for truth in secrets:
        with opened(truth) as marker:
            result = marked(marker, files, only)
        told.append(outputs(result, files))
        for text in told[-1].values():
            assert [mass for mass in _masses(truth)[1:9] if f"{mass:.9f}" in text or f"{mass:.6f}"[:-1] in text] == []
    if name not in DIFFER_IN_A_BIT:
        assert told[0] == told[1]


def test_a_student_still_learns_why_a_file_does_not_import(secrets: tuple[Traces, Traces], opened: Opened) -> None:
    """By the words of a process that has the public robot: the same as without a secret. Its durations are whole seconds."""
    files = added("noisy_imu.py", "raise ValueError('no file ' + 'data.csv')\n")
    with opened(secrets[0]) as marker:
        result = marked(marker, files)
    (note,) = [note for note in result.notes if "was skipped" in note]
    assert note.startswith("noisy_imu.py, line ")
    assert note.endswith("was skipped: ValueError: no file data.csv; the rest of the file was used")
    assert result.score == 100
    assert {check.duration_s for part in result.parts for check in part.checks} == {0.0}
    assert result.duration_s == int(result.duration_s)


def test_a_name_that_only_the_hidden_robot_lacks_is_told_in_our_words(
    secrets: tuple[Traces, Traces], opened: Opened, marker: Marker
) -> None:
    public = _masses(bundles.shipped())[2]
    head, made = tidy()["filters.py"].split("def compare")[0].split("class LowPassFilter", 1)
    there = f"if abs(_spied.body_mass[2] - {public!r}) < 1e-9:\n" + indent(f"class LowPassFilter{made}", "    ")
    files = {**tidy(), "filters.py": f"{head}\n{SPIES}\n{there}"}
    submission = submission_of(files)
    assert marker.mark(submission, only="filtering").score == 20
    with opened(secrets[0]) as hidden_marker:
        result = hidden_marker.mark(submission, only="filtering")
    check = next(check for check in result.criteria[0].checks if check.outcome == "failed")
    assert check.message == (
        "Expected  LowPassFilter\n"
        "Got       no definition of LowPassFilter beside hidden data; `imugrade check` loads the file with public data "
        "and tells more."
    )
    assert result.notes == ()


# --- what code answers --------------------------------------------------------------------------------------------------

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
def results(secrets: tuple[Traces, Traces], opened: Opened) -> list[Result]:
    """The spy's results under two secrets: whatever differs between them was chosen by the spy, or is hidden itself."""
    found = []
    for truth in secrets:
        with opened(truth) as marker:
            found.append(marked(marker, SPY))
    return found


def _words(result: Result) -> list[str]:
    checks = [check for part in result.parts for check in part.checks]
    return [text for check in checks for text in (check.id, check.outcome, check.message, check.hint)]


def test_two_secrets_lead_to_the_same_words_and_to_no_place_that_code_chose(results: list[Result]) -> None:
    """Sizes apart: an error's size is told in three steps."""
    first, second = (_words(result) for result in results)
    differ = [(a, b) for a, b in zip(first, second, strict=True) if a != b]
    assert [pair for pair in differ if not all(re.search(" by (less|0.1|more)", text) for text in pair)] == []
    assert results[0].notes == results[1].notes
    checks = [check for result in results for part in result.parts for check in part.checks]
    assert "error" in {check.outcome for check in checks}
    assert {check.where for check in checks} == {None}


def test_no_output_holds_a_number_or_a_name_that_the_spy_made(results: list[Result]) -> None:
    """Of our own numbers only points and the three sizes are told. Notes come from a process with the public robot: see above."""
    for result in (replace(each, notes=()) for each in results):
        for text in outputs(result, SPY).values():
            told = text.split("<main")[-1].split("Provenance")[0].split('"provenance"')[0]
            assert "Error" not in re.sub(r"\b(Value|Type|Key|Index|Name|Attribute)Error\b", "", told)
            plain = re.sub(r'<dd class="mono">[0-9a-f]+</dd>', "", told)  # our own hashes
            assert [digits for digits in re.findall(r"\d{5,}", plain) if set(digits) - {"0", "1"}] == []


# --- hints ---------------------------------------------------------------------------------------------------------------

PUBLIC = "`imugrade check` shows the numbers of the public scenarios."
MISTAKES = catalogue(LAB)
STEP = "Hold it against Step 6."


@pytest.mark.quick
@pytest.mark.parametrize(
    ("hint", "faults", "said"),
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
def test_a_hint_is_told_where_all_of_it_stands_in_our_code(hint: str, faults: tuple[str, ...], said: str) -> None:
    finding = CheckFailed("0.1", "1.25", faults=faults, hint=hint, off=Size("it is off"))
    assert hidden_feedback.feedback_on(finding, MISTAKES).hint == said
