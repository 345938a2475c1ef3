"""Runs the corpus without the grader and says what each sample really does: `python -m tests.corpus.proof [PART] [--only NAME]`.

A sample that is not what it claims to be is worse than none. Each submission runs in a process of its own (forked from one
that has imported MuJoCo and Matplotlib), in a scratch folder with the lab model at the sheet's path; then a few blunt
questions are asked of its functions. Nothing here is a wall: this is for our own samples only.
"""

from __future__ import annotations

import argparse
import inspect
import json
import os
import re
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import mujoco
import mujoco.viewer
import numpy as np
from matplotlib.figure import Figure

from tests.corpus.machine import REAL_MODEL, SHEET_MODEL, figure_facts, patch, run_scripts, unpacked
from tests.corpus.writing import Files, write

CRITERIA = ("sensor_access", "data_collection", "visualization", "noise_model", "filtering")
PATIENCE_S = 60

Problems = dict[str, list[str]]



def find(spaces: list[dict[str, Any]], name: str) -> Any:
    return next((space[name] for space in spaces if name in space), None)


# ---------------------------------------------------------------- the questions

OTHER_LAYOUT = ("<sensor>", '<sensor><clock name="early"/><framepos name="more" objtype="site" objname="torso_imu"/>')


def lab_model(timestep: float | None = None, shifted: bool = False) -> Any:
    text = REAL_MODEL.read_text(encoding="utf-8")
    model = mujoco.MjModel.from_xml_string(text.replace(*OTHER_LAYOUT) if shifted else text)
    if timestep:
        model.opt.timestep = timestep
    return model


def true_reading(model: Any, data: Any, accel_id: int, gyro_id: int) -> tuple[Any, Any]:
    a, g = (model.sensor_adr[i] for i in (accel_id, gyro_id))
    return data.sensordata[a : a + 3].copy(), data.sensordata[g : g + 3].copy()


def ids(model: Any, place: str = "torso") -> tuple[int, int]:
    return model.sensor(f"{place}_accelerometer").id, model.sensor(f"{place}_gyroscope").id


def true_recording(model: Any, duration: float) -> dict[str, Any]:
    data = mujoco.MjData(model)
    data.qvel[0] = 0.5
    rows = []
    for _ in range(round(duration / model.opt.timestep)):
        mujoco.mj_step(model, data)
        rows.append(np.hstack((data.time, *true_reading(model, data, *ids(model)))))
    table = np.array(rows)
    return {"time": table[:, 0], "acceleration": table[:, 1:4], "angular_velocity": table[:, 4:]}


def same(name: str, got: Any, expected: Any, tolerance: float = 1e-6) -> list[str]:
    try:
        got = np.asarray(got, dtype=float)
    except (TypeError, ValueError) as problem:
        return [f"{name}: {problem}"]
    if got.shape != np.shape(expected):
        return [f"{name}: shape {got.shape}, not {np.shape(expected)}"]
    worst = np.max(np.abs(got - expected), initial=0.0)
    return [] if worst <= tolerance else [f"{name}: off by {worst:.3g}"]


def ask_sensor_access(spaces: list[dict[str, Any]]) -> list[str]:
    read, problems = find(spaces, "get_imu_readings"), []
    for shifted, place in ((False, "torso"), (True, "torso"), (False, "head")):
        model = lab_model(shifted=shifted)
        data = mujoco.MjData(model)
        data.qvel[:] = np.linspace(-1, 1, model.nv)
        for _ in range(20):
            mujoco.mj_step(model, data)
        state = np.hstack((data.time, data.qpos, data.qvel, data.sensordata))
        truth = true_reading(model, data, *ids(model, place))
        answer = read(model, data, *ids(model, place))
        problems += same(f"{place} {shifted}", answer, truth, 1e-9)
        if not np.array_equal(state, np.hstack((data.time, data.qpos, data.qvel, data.sensordata))):
            problems.append("the simulation was disturbed")
        mujoco.mj_step(model, data)
        problems += same("kept", answer, truth, 1e-9)
    return problems


def sensor_parameters(function: Callable[..., Any], model: Any) -> dict[str, int]:
    found: dict[str, int] = {}
    for name, parameter in inspect.signature(function).parameters.items():
        accel, gyro = ids(model)
        if parameter.default is inspect.Parameter.empty or parameter.default is None:
            found |= {name: accel} if name.startswith("acc") else {name: gyro} if name.startswith("gyr") else {}
    return found


def ask_data_collection(spaces: list[dict[str, Any]]) -> list[str]:
    collect, problems = find(spaces, "simulate_and_collect"), []
    for timestep, duration in ((0.002, 1.0), (0.004, 0.6)):
        model = lab_model(timestep)
        data = mujoco.MjData(model)
        data.qvel[:3] = 0.3
        for _ in range(7):
            mujoco.mj_step(model, data)
        collect.__globals__.update({k: v for k, v in zip(("accel_id", "gyro_id"), ids(model), strict=True) if k not in collect.__globals__})
        truth = true_recording(model, duration)
        wrapped = getattr(collect, "__wrapped__", collect)
        answer = collect(model=model, data=data, duration_seconds=duration, **sensor_parameters(wrapped, model))
        if model.opt.timestep != timestep or model.opt.gravity[2] != -9.81:
            problems.append("the model was changed")
        n = len(answer["time"])
        if n == len(truth["time"]) + 1 and answer["time"][0] == 0:  # the state before the first step as well
            answer = {key: answer[key][1:] for key in truth}
        if abs(n - len(truth["time"])) > 1:
            problems.append(f"{n} samples, not {len(truth['time'])}")
            continue
        n = min(n, len(truth["time"]))
        after = same("time", answer["time"][:n], truth["time"][:n], 1e-9)
        problems += after and same("time", answer["time"][:n], truth["time"][:n] - timestep, 1e-9)
        for key in ("acceleration", "angular_velocity"):
            problems += same(key, answer[key][:n], truth[key][:n])
    return problems


UNITS = {
    "acceleration": r"m(/s2|/sec2|s-2|/s/s|/s2|(et(er|re)s?)persecondsquared|s2)",
    "angular velocity": r"(rads?|deg)(/s|s-1|s)|radianspersecond",
    "time": r"\(s\)|\[s\]|/s\b|,s|ins|s(ec|econds?)\b|sample",
}


def plain(label: str) -> str:
    """A label without the marks of mathematics, blanks and raised figures."""
    label = label.translate(str.maketrans("²⁻¹", "2-1"))
    return re.sub(r"\\(mathrm|frac)|\\,|\*\*|[\s${}^·]", "", label)


def ask_visualization(spaces: list[dict[str, Any]], saved: list[dict[str, Any]]) -> list[str]:
    problems = []
    if not any(_is_comparison(facts) for facts in saved):
        problems.append("no comparison of raw and filtered was drawn")
    plot = find(spaces, "plot_imu_data")
    truth = true_recording(lab_model(), 1.6)
    before = len(saved)
    returned = plot(truth)
    drawn = saved[before:] or ([figure_facts(returned, returned.dpi)] if isinstance(returned, Figure) else [])
    if not drawn:
        return [*problems, "nothing was saved"]
    facts = drawn[-1]
    for key in ("acceleration", "angular_velocity"):
        for k in range(3):
            if not any(_shows(curve, truth["time"], truth[key][:, k]) for curve in facts["curves"]):
                problems.append(f"no curve shows {key} {k}")
    labels = " | ".join(facts["labels"])
    problems += [f"no unit of {what}: {labels}" for what, unit in UNITS.items() if not re.search(unit, plain(labels))]
    if not facts["titles"]:
        problems.append("no title")
    names = facts["legend"] or facts["beside"]
    if len(names) < 3 and facts["panels"] < 6:
        problems.append("curves have no names")
    if min(facts["pixels"]) < 300:
        problems.append(f"an image of {facts['pixels']} pixels")
    return problems


def _is_comparison(facts: dict[str, Any]) -> bool:
    """A curve of white noise and a smoother one over the same samples."""
    long = [y for _, y in facts["curves"] if len(y) >= 200]
    rough = [np.median(np.abs(np.diff(y))) for y in long]
    if len(long) < 2 or len({len(y) for y in long}) > 1:
        return False
    roughest = int(np.argmax(rough))
    return bool(min(rough) < 0.5 * max(rough) and rough[roughest] > 0.3 * np.std(long[roughest]))


def _shows(curve: tuple[Any, Any], time: Any, values: Any) -> bool:
    x, y = curve
    if len(x) < 200 or x.min() < time[0] - 0.01 or x.max() > time[-1] + 0.01 or x.max() < 0.9 * time[-1]:
        return False
    before, after = np.interp(x, time, values), np.interp(x + time[0], time, values)  # stamped before or after the step
    scales = (1.0, 180 / np.pi)
    return any(np.allclose(y, there * k, atol=1e-6 * k, rtol=1e-5) for there in (before, after) for k in scales)


def ask_noise_model(spaces: list[dict[str, Any]]) -> list[str]:
    make, problems = find(spaces, "NoisyIMU"), []
    model = lab_model()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    state = data.sensordata.copy()
    clean = np.hstack(true_reading(model, data, *ids(model)))
    bias = np.array([0.5, -0.3, 0.2]), np.array([0.02, 0.03, -0.04])
    imu = make(model, data, *ids(model), 0.08, 0.003, *bias)
    sample = np.array([np.hstack(imu.read()) for _ in range(4000)]) - clean
    sigma = np.repeat([0.08, 0.003], 3)
    noise = (sample - np.hstack(bias)) / sigma
    problems += [f"mean off by {m:.2f} sigma" for m in noise.mean(axis=0) if abs(m) > 0.1]
    problems += [f"std is {s:.3f} of what it should be" for s in noise.std(axis=0) if abs(s - 1) > 0.07]
    kurtosis = (((noise - noise.mean(0)) / noise.std(0)) ** 4).mean(axis=0) - 3
    problems += [f"excess kurtosis {k:.2f}" for k in kurtosis if abs(k) > 0.5]
    correlation = np.abs(np.corrcoef(noise.T) - np.eye(6)).max()
    lagged = np.abs((noise[1:] * noise[:-1]).mean(axis=0)).max()
    problems += [f"{what} {c:.2f}" for what, c in (("axes correlate", correlation), ("reads correlate", lagged)) if c > 0.1]
    if not np.array_equal(state, data.sensordata):
        problems.append("sensordata was changed")
    problems += _moving_noise(make, model)
    return problems + _default_bias(make, model, data, clean)


def _default_bias(make: Any, model: Any, data: Any, clean: Any) -> list[str]:
    biases = []
    for _ in range(40):
        imu = make(model, data, *ids(model), accel_noise_std=1e-9, gyro_noise_std=1e-9)
        first, second = np.hstack(imu.read()), np.hstack(imu.read())
        if np.abs(first - second).max() > 1e-6:
            return ["the bias changes between reads"]
        biases.append(first - clean)
    spread = np.std(biases, axis=0)
    problems = ["the default bias does not vary"] if spread.min() < 1e-4 else []
    if np.abs(np.corrcoef(np.transpose(biases)) - np.eye(6)).max() > 0.9:
        problems.append("the default biases of axes are the same")
    imu = make(model, data, *ids(model), accel_noise_std=0.0, gyro_noise_std=0.0, accel_bias=np.zeros(3), gyro_bias=np.zeros(3))
    return problems + same("without noise and bias", np.hstack(imu.read()), clean, 1e-9)


def _moving_noise(make: Any, model: Any) -> list[str]:
    data = mujoco.MjData(model)
    data.qvel[:6] = 1
    imu = make(model, data, *ids(model), 1e-9, 1e-9, np.zeros(3), np.zeros(3))
    problems = []
    for _ in range(5):
        mujoco.mj_step(model, data)
        problems += same("follows the motion", np.hstack(imu.read()), np.hstack(true_reading(model, data, *ids(model))), 1e-6)
    return problems


def ask_filtering(spaces: list[dict[str, Any]]) -> list[str]:
    make, problems = find(spaces, "LowPassFilter"), []
    x = np.random.default_rng(5).normal([0, 5, -9.81], 1, (60, 3))
    for alpha, start in ((0.1, None), (0.35, None), (0.2, np.array([1.0, -2.0, 3.0]))):
        other, low_pass = make(alpha=alpha), make(alpha) if start is None else make(alpha, start)
        other.update(np.array([99.0, 99.0, 99.0]))
        y = None if start is None else start.copy()
        for row in x:
            y = row if y is None else alpha * row + (1 - alpha) * y
            given = row.copy()
            answer = low_pass.update(given)
            problems += same("recursion", answer, y, 1e-9)
            problems += same("its input", given, row, 0)
            given += 7.0
            if isinstance(answer, np.ndarray):
                answer += 5.0
        if start is not None and not np.array_equal(start, [1.0, -2.0, 3.0]):
            problems.append("the initial value was changed")
    return problems[:4]


# ---------------------------------------------------------------- one submission, all submissions

# A fault that stops the script also stops what the script would have shown of the other criteria; this proof has no
# stand-ins for scripts, and looks at the criterion alone.
STOPS = {
    "raises", "never-returns", "kills-its-process", "wrong-return-type", "wrong-length", "not-finite", "name-missing", "missing-package",
    "file-missing", "does-not-import", "unknown-name", "other-parameters", "wrong-keys", "arrays-transposed",
}  # fmt: skip
UNREAD = {"legend-order-wrong", "panels-swapped", "one-panel"}  # it reads no words


def judge(path: Path, scratch: Path) -> Problems:
    """Problems by criterion, in this process; it will not be usable for another submission."""
    saved: list[dict[str, Any]] = []
    patch(saved)
    folder = unpacked(path, scratch / "unpacked")
    for place in {scratch, folder}:
        (place / SHEET_MODEL).parent.mkdir(parents=True, exist_ok=True)
        (place / SHEET_MODEL).write_bytes(REAL_MODEL.read_bytes())
    os.chdir(folder)
    np.random.seed(1)
    spaces = run_scripts(folder)
    questions: dict[str, Callable[[], list[str]]] = {
        "sensor_access": lambda: ask_sensor_access(spaces),
        "data_collection": lambda: ask_data_collection(spaces),
        "visualization": lambda: ask_visualization(spaces, saved),
        "noise_model": lambda: ask_noise_model(spaces),
        "filtering": lambda: ask_filtering(spaces),
    }
    problems = {}
    for criterion, question in questions.items():
        try:
            problems[criterion] = question()
        except (Exception, SystemExit) as problem:
            last = traceback.extract_tb(problem.__traceback__)[-1]
            problems[criterion] = [f"{type(problem).__name__}: {problem} ({Path(last.filename).name}:{last.lineno})"]
        for space in [*spaces, *map(vars, sys.modules.copy().values())]:
            if "get_imu_readings" in space and space.get("__name__") != __name__:
                space["get_imu_readings"] = true_reading
    return problems


def judged(files: Files, as_: str = "folder", *, verbose: bool = False) -> Problems:
    """Problems by criterion, from a forked process that is given up after a minute."""
    with tempfile.TemporaryDirectory() as scratch:
        answer = Path(scratch) / "answer.json"
        child = os.fork()
        if child == 0:
            signal.alarm(PATIENCE_S)
            output = os.open("/dev/null" if not verbose else "/dev/stderr", os.O_WRONLY)
            os.dup2(output, 1)
            os.dup2(output, 2)
            try:
                found = judge(write(files, Path(scratch) / "work" / "submission", as_), Path(scratch) / "work")
                answer.write_text(json.dumps(found))
            except BaseException:
                traceback.print_exc()
            finally:
                os._exit(0)
        os.waitpid(child, 0)
        if not answer.exists():
            return {criterion: ["the process did not come back"] for criterion in CRITERIA}
        problems: Problems = json.loads(answer.read_text())
        return problems


def show(part: str, only: str | None, verbose: bool) -> int:
    """Print what is not as claimed, a line each, and return the number of such samples."""
    from tests.corpus.faulty import FAULTY, LOOKALIKES, PAIRS
    from tests.corpus.sound import SOUND, WRAPPED

    claims: dict[str, tuple[Files, str, set[str]]] = {}
    blind: set[str] = set()
    unread: dict[str, set[str]] = {}
    if part in ("sound", "all"):
        claims |= {name: (files, WRAPPED.get(name, "folder"), set()) for name, files in SOUND.items()}
    if part in ("faulty", "all"):
        claims |= {f.name: (f.files, "folder", {f.criterion} - {""}) for f in (*FAULTY, *LOOKALIKES)}
        claims |= {p.name: (p.files, "folder", {c for _, c in p.faults}) for p in PAIRS}
        unread = {f.name: {f.criterion} for f in FAULTY if f.mistake in UNREAD}
        blind = {f.name for f in FAULTY if f.mistake in STOPS}
    wrong = 0
    for name, (files, as_, expected) in claims.items():
        if only and only not in name:
            continue
        problems = judged(files, as_, verbose=verbose)
        found = {criterion for criterion, lines in problems.items() if lines}
        found = found & expected if name in blind else found | unread.get(name, set())
        wrong += found != expected
        mark = "as claimed" if found == expected else f"CLAIMS {sorted(expected)}, SHOWS"
        if found != expected or verbose:
            print(f"{name}: {mark} " + "; ".join(f"{c}: {lines[:3]}" for c, lines in problems.items() if lines), flush=True)
    print(f"{len(claims)} samples, {wrong} not as claimed")
    return wrong


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("part", nargs="?", choices=("sound", "faulty", "all"), default="all")
    parser.add_argument("--only")
    parser.add_argument("-v", "--verbose", action="store_true")
    options = parser.parse_args()
    sys.exit(show(options.part, options.only, options.verbose) > 0)
