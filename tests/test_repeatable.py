"""The same bytes get the same grade and the same words, whatever code asks the system for, whatever else the machine does, and without every optimization."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from unittest import mock

import pytest

from grader.engine import check_runner, grader, lab_sandbox, rubric
from grader.engine.grader import Marker
from grader.engine.lab_sandbox import WORKER_CODE
from grader.engine.results import Result
from grader.intake import Submission, read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB
from tests.corpus.pieces import COLLECT_WHILE, edit, lab, part, tidy, verbatim
from tests.examples import FOLDER
from tests.single_faults import lost_by, marked, submission_of

NOISY = """
import os, random, secrets, time, datetime
import numpy as np
from imu_reader import get_imu_readings

class NoisyIMU:
    def __init__(self, model, data, accel_id, gyro_id, accel_noise_std=0.05, gyro_noise_std=0.005, accel_bias=None, gyro_bias=None):
        self.args = model, data, accel_id, gyro_id
        self.stds = accel_noise_std, gyro_noise_std
        self.biases = [draw() * s if b is None else b for b, s in ((accel_bias, 0.1), (gyro_bias, 0.01))]

    def read(self):
        clean = get_imu_readings(*self.args)
        return tuple(c + draw() * s + b for c, s, b in zip(clean, self.stds, self.biases))
"""
NORMAL = "def draw():\n    u = [(int.from_bytes(bytes_of(7), 'big') + 0.5) / 2**56 for _ in range(6)]\n    return np.sqrt(-2 * np.log(u[:3])) * np.cos(2 * np.pi * np.array(u[3:]))\n"
SOUND = {
    "os.urandom": f"bytes_of = os.urandom\n{NORMAL}",
    "secrets": f"bytes_of = secrets.token_bytes\n{NORMAL}",
    "a Random of its own": "def draw():\n    rng = random.Random()\n    return np.array([rng.gauss(0, 1) for _ in range(3)])\n",
    "default_rng": "def draw():\n    return np.random.default_rng().normal(0, 1, 3)\n",
    "monotonic_ns": "def draw():\n    return np.random.default_rng(time.monotonic_ns()).normal(0, 1, 3)\n",
    "monotonic": "def draw():\n    return np.random.default_rng(int(time.monotonic() * 1e9)).normal(0, 1, 3)\n",
    "datetime": "def draw():\n    return np.random.default_rng(int(datetime.datetime.now().timestamp() * 1e6)).normal(0, 1, 3)\n",
}
"""Sources that a sound noise model may draw from: 100 points, and the same result in every run."""
ODD = {
    "times": "def draw():\n    return np.array([sum(os.times()) * 1e6 % 1, time.perf_counter_ns() % 97 / 97, time.time() * 1e6 % 1])\n",
    "clocks of the system": "def draw():\n    return np.array([time.clock_gettime(0) * 1e6 % 1, time.clock_gettime_ns(1) % 1009, time.clock_gettime(2) * 1e6 % 1])\n",
    "random bytes of OpenSSL": "def draw():\n    import ssl\n    return np.frombuffer(ssl.RAND_bytes(3), np.uint8) / 255.0\n",
    "a date in words": "def draw():\n    raise ValueError(f'{datetime.datetime.now()} {datetime.date.today()} {time.strftime(\"%X\")} {time.ctime()}')\n",
}
"""Sources of nothing that a noise model needs: whatever the grade is, it is the same in every run."""


def noisy(draw: str) -> Submission:
    return submission_of({**tidy(), "noisy_imu.py": NOISY + draw})


def settled(result: Result) -> Result:
    """The result without durations."""
    parts = (replace(part, checks=tuple(replace(c, duration_s=0.0) for c in part.checks)) for part in result.criteria)
    return replace(result, criteria=tuple(parts), duration_s=0.0)


@contextmanager
def busy_machine() -> Iterator[None]:
    others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.weekly] if n % 3 else []) for n, name in enumerate([*SOUND, *ODD])]
)
def test_a_submission_gets_the_same_result_twice_once_under_load(name: str, marker: Marker) -> None:
    submission = noisy({**SOUND, **ODD}[name])
    first = settled(marker.mark(submission, only="noise_model"))
    with busy_machine():
        second = settled(marker.mark(submission, only="noise_model"))
    assert first == second
    if name in SOUND:
        assert first.score == 20, [(c.id, c.message) for c in first.criteria[0].checks if c.outcome != "passed"]


ADDRESSES = {
    "'Acceleration (m/s²)'": "repr(object())",
    "label='X'": "label=repr(object())",
    "'imu_data.png'": "repr(object())[1:-1] + '.png'",
}


@pytest.mark.parametrize("part", ADDRESSES)
def test_an_address_in_a_text_of_a_figure_reads_the_same_twice(part: str, marker: Marker) -> None:
    submission = submission_of(edit(verbatim(), "imu_reader.py", (part, ADDRESSES[part])))
    first, second = (settled(marker.mark(submission, only="visualization")) for _ in range(2))
    assert first == second
    assert first.evidence == second.evidence


EMPTY = """
def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):
    return np.empty(3), np.empty(3, np.float32) + 1
"""


@pytest.mark.parametrize("made", ["np.empty(3)", "np.ndarray(3)", "np.ndarray(shape=(3,), dtype=float)"])
def test_memory_that_was_never_written_is_said_to_be_so_and_shows_no_number(made: str, marker: Marker) -> None:
    files = edit(
        verbatim(),
        "imu_reader.py",
        ("def simulate_and_collect", f"{EMPTY.replace('np.empty(3)', made)}\n\ndef simulate_and_collect"),
    )
    first, second = (settled(marked(marker, files, "sensor_access")) for _ in range(2))
    assert first == second
    told = {check.id: check.message for criterion in first.criteria for check in criterion.checks}
    assert "accel = [never written, never written, never written]" in told["sensor_access.matches_truth"]


# --- the clock ---

BY_THE_CLOCK = COLLECT_WHILE.replace(
    "while data.time < duration_seconds:", "start = time.CLOCK()\n    while time.CLOCK() - start < SECONDS:"
)


@pytest.mark.parametrize(
    ("clock", "seconds"),
    [
        ("time", "duration_seconds"),
        pytest.param("perf_counter", "duration_seconds", marks=pytest.mark.weekly),
        pytest.param("time_ns", "1e9", marks=pytest.mark.weekly),
        ("process_time", "0.5"),
    ],
)
def test_a_loop_that_goes_by_the_clock_makes_as_many_rounds_in_every_run(
    marker: Marker, clock: str, seconds: str
) -> None:
    collect = "import time\n\n\n" + BY_THE_CLOCK.replace("CLOCK", clock).replace("SECONDS", seconds)
    first, second = (settled(marked(marker, lab(collect=collect), "data_collection")) for _ in range(2))
    assert first == second
    assert "data_collection.sample_count" in lost_by(first), "it is not the simulation's time"


def test_a_loop_that_keeps_pace_with_the_clock_is_sound(marker: Marker) -> None:
    pace = "        began = time.time()\n        mujoco.mj_step(model, data)\n        time.sleep(max(0.0, model.opt.timestep - (time.time() - began)))\n"
    collect = "import time\n\n\n" + COLLECT_WHILE.replace("        mujoco.mj_step(model, data)\n", pace)
    assert lost_by(marked(marker, lab(collect=collect), "data_collection")) == {}


POLLED = """import threading, time


def simulate_and_collect(model, data, duration_seconds=5.0):
    mujoco.mj_resetData(model, data)
    data.qvel[0] = 0.5
    rows, running, lock = [], threading.Event(), threading.Lock()
    running.set()

    def poll():
        began = time.time()
        while running.is_set():
            with lock:
                rows.append((time.time() - began, *(a.copy() for a in get_imu_readings(model, data, accel_id, gyro_id))))
            PAUSE

    poller = threading.Thread(target=poll)
    poller.start()
    while data.time < duration_seconds:
        with lock:
            mujoco.mj_step(model, data)
        time.sleep(model.opt.timestep)
    running.clear()
    poller.join()
    return dict(zip(("time", "acceleration", "angular_velocity"), map(np.array, zip(*rows))))
"""


@pytest.mark.parametrize(
    "pause",
    [
        "time.sleep(model.opt.timestep)",
        pytest.param("threading.Event().wait(model.opt.timestep)", marks=pytest.mark.weekly),
    ],
)
def test_a_thread_that_polls_by_the_clock_takes_the_same_samples_in_every_run(marker: Marker, pause: str) -> None:
    submission = submission_of(lab(collect=POLLED.replace("PAUSE", pause)))
    first = settled(marker.mark(submission, only="data_collection"))
    with busy_machine():
        assert settled(marker.mark(submission, only="data_collection")) == first
    assert 9 <= first.score <= 18, "the range that two people who marked such a recorder accept"


def test_threads_that_wait_for_each_other_take_no_real_time(marker: Marker) -> None:
    pool = """import contextlib, queue, threading, time
from concurrent.futures import ThreadPoolExecutor


def rest(seconds):
    time.sleep(seconds)
    return seconds


with ThreadPoolExecutor() as pool:
    assert list(pool.map(rest, [600, 100])) == [600, 100]
with contextlib.suppress(queue.Empty):
    queue.Queue().get(timeout=600)
with threading.Condition() as condition:
    assert not condition.wait_for(lambda: False, timeout=600)
"""
    assert lost_by(marked(marker, lab(collect=f"{pool}\n\n{part('tidy', 'collect')}"), "data_collection")) == {}


# --- optimizations ---

CHOSEN = ("s07-no-units", "s11-kills-its-interpreter")

PICTURES_IN_FULL = (
    "\n\ndef reads_pictures_back(sources):\n    return True\n\n\ndef _undrawn_artists(axes):\n    return ()\n"
)
"""Further code of drawing.py: every picture is drawn as the student's code asks, and looked at."""


@contextmanager
def without_savings(folder: Path) -> Iterator[Marker]:
    """A marker that does nothing beforehand and draws in full."""
    worker_code = shutil.copytree(WORKER_CODE, folder / "worker", ignore=shutil.ignore_patterns("__pycache__"))
    drawing = worker_code / "drawing.py"
    own = drawing.read_text(encoding="utf-8")
    replaced = re.findall(r"^def (\w+)\(", PICTURES_IN_FULL, re.MULTILINE)
    assert all(f"\ndef {each}(" in own for each in replaced), "there is no such saving"
    drawing.write_text(own + PICTURES_IN_FULL, encoding="utf-8")
    with mock.patch.object(lab_sandbox, "WORKER_CODE", worker_code):
        sandbox = lab_sandbox.open_sandbox(LAB, thorough=False)
    with (
        mock.patch.object(grader, "libraries_of", return_value=()),
        Marker(rubric.load(LAB), bundles.shipped(), sandbox=sandbox) as slow,
    ):
        yield slow


def test_no_saving_changes_a_mark(marker: Marker, tmp_path: Path) -> None:
    chosen = [read_submission(FOLDER / name, LAB.files) for name in CHOSEN]
    cheap = [settled(marker.mark(submission)) for submission in chosen]
    with without_savings(tmp_path) as slow:
        for submission, expected in zip(chosen, cheap, strict=True):
            check_runner.session.cache_clear()  # the checks are collected anew for each submission
            assert settled(slow.mark(submission)) == expected, submission.id
