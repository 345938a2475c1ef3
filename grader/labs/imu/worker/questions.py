"""Run a student's functions of Steps 2 to 4 (read, record, plot) on given states and report the results, one operation each.

A reply consists of fields and arrays. An exception of the student's ends the operation and is reported with the earlier results.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from grader.worker import environment, faults, recorder, saved, submission
from grader.worker.calling import plan_call
from grader.worker.screen import replaced
from grader.worker.values import Packer, numbers

from . import calls, own_globals, simulation

Reply = tuple[dict[str, Any], dict[str, np.ndarray]]


@contextmanager
def reporting_errors(answer: dict[str, Any]) -> Iterator[None]:
    """Run student code in the scratch folder; catch any exception, and put its description into ``answer["error"]``."""
    try:
        with environment.in_scratch_folder(submission.STATE.folder):
            yield
    except BaseException as raised:  # whatever student code raises, SystemExit included
        answer["error"] = faults.describe(raised)


def parts_of(value: Any) -> list[tuple[str, Any]]:
    """Return (name, part) pairs of a dict, list, tuple, array or object, to find vectors ("" for no name); TypeError for others."""
    if isinstance(value, dict):
        return [(str(name), part) for name, part in value.items()]
    if isinstance(value, tuple | list | np.ndarray):
        return [("", part) for part in value]
    return list(vars(value).items())


def vectors_in(parts: Iterable[tuple[str, Any]]) -> list[tuple[str, np.ndarray]]:
    """Return those of `parts` (name, value) that consist of three numbers, as float arrays: they may be an accel or gyro vector."""
    found = []
    for name, part in parts:
        with suppress(TypeError, ValueError):
            found += [(name, numbers(part).reshape(3))]
    return found


# --- the reader ----------------------------------------------------------------------------------------------------------


def read(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Call `get_imu_readings` with every pair of sensors in every state, to check its values and whether they are views.

    Parameters
    ----------
    fields : ``path`` (the student's file), ``model`` (XML text)
    arrays : ``qpos`` (k, nq), ``qvel`` (k, nv), ``pairs`` (p, 2) sensor ids

    Returns
    -------
    ``calls`` : a description of the value returned for each pair and state; ``later`` : for each pair, a new description of the
        value from the first state, after a step and another call: it differs if that value is a view into MuJoCo's data
    array ``disturbance`` (calls, 4): largest change of time, qpos, qvel and sensordata by each call. The rows of a pair are the
        first state, the other call after the step, and the other states
    """
    reader = submission.find("get_imu_readings", fields["path"])
    packer = Packer()
    answer: dict[str, Any] = {"calls": [], "later": [], "departs": []}
    disturbance = []
    with reporting_errors(answer), scene(fields["model"]) as (model, data):
        own_globals.provide_ids_of(model)
        reading_of = calls.Reader(reader)
        reading_of.departs += own_globals.globals_read_instead(reader, (calls.MODEL, calls.DATA))
        answer["departs"] = reading_of.departs
        for accel_id, gyro_id in arrays["pairs"]:
            for index in range(len(arrays["qpos"])):
                put_in_state(model, data, arrays["qpos"][index], arrays["qvel"][index])
                before = state_of(data)
                reading = reading_of(model, data, int(accel_id), int(gyro_id))
                answer["calls"].append(packer.node(reading))
                disturbance.append(changes_of(before, state_of(data)))
                if index == 0:
                    step_and_shift(model, data)
                    before = state_of(data)
                    reading_of(model, data, int(accel_id), int(gyro_id))  # into arrays of its own, or the same again
                    disturbance.append(changes_of(before, state_of(data)))
                    answer["later"].append(packer.node(reading))
    return answer, packer.arrays | {"disturbance": np.array(disturbance).reshape(-1, 4)}


@functools.cache
def _compiled(xml: str) -> Any:
    import mujoco

    return mujoco.MjModel.from_xml_string(xml)


def model_of(xml: str) -> Any:
    """Return a fresh copy of the model in `xml` (MJCF), compiled once, so that student code cannot change it for later requests."""
    return _compiled(xml).__copy__()


def simulation_of(xml: str) -> tuple[Any, Any]:
    import mujoco

    model = model_of(xml)
    return model, mujoco.MjData(model)


@contextmanager
def scene(xml: str) -> Iterator[tuple[Any, Any]]:
    """Yield a fresh model and its data for a call; until exit, the submission's globals for model and data are set to them."""
    model, data = simulation_of(xml)
    with own_globals.set_model_and_data(model, data):
        yield model, data


def put_in_state(model: Any, data: Any, qpos: Any, qvel: Any) -> None:
    """Reset the simulation, set its state and compute the sensor readings, so that nothing of an earlier state is left."""
    import mujoco

    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, data)


def state_of(data: Any) -> tuple[np.ndarray, ...]:
    return tuple(np.array(v, dtype=np.float64).ravel() for v in (data.time, data.qpos, data.qvel, data.sensordata))


def changes_of(before: tuple[np.ndarray, ...], after: tuple[np.ndarray, ...]) -> list[float]:
    return [float(np.max(np.abs(b - a), initial=0.0)) for a, b in zip(before, after, strict=True)]


def step_and_shift(model: Any, data: Any) -> None:
    """Step the simulation, then add 1 to all sensor data, so that a view into the data differs from a copy even at rest."""
    import mujoco

    mujoco.mj_step(model, data)
    data.sensordata[:] += 1.0  # so that a view shows itself even where the motion would not


# --- data collection -----------------------------------------------------------------------------------------------------


def simulate(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Call the student's `simulate_and_collect` on a model, with data that are just reset, or in the state ``qpos`` and ``qvel``.

    The reply has the returned ``value``, what the call ``changed`` in the model, and the run for `replay`: the
    arrays of `watched_run`, named ``first_…``, such as ``first_qpos`` (before the first step) or ``first_steps`` (how many).

    Parameters
    ----------
    fields : ``path``, ``model`` (XML text), ``duration_s``, ``timestep`` (None: the model's), ``accel_id``, ``gyro_id``,
        ``time_s`` of the state
    arrays : optional ``qpos`` (nq,), ``qvel`` (nv,), the state; optional ``gravity`` (3,) in place of the model's
    """
    import mujoco

    function = submission.find("simulate_and_collect", fields["path"])
    model = model_of(fields["model"])
    if fields["timestep"]:
        model.opt.timestep = fields["timestep"]
    if "gravity" in arrays:
        model.opt.gravity[:] = arrays["gravity"]
    data = mujoco.MjData(model)
    if "qpos" in arrays:
        data.qpos[:], data.qvel[:], data.time = arrays["qpos"], arrays["qvel"], fields["time_s"]
        mujoco.mj_forward(model, data)
    ids = {"accel": fields["accel_id"], "gyro": fields["gyro_id"]}
    own_globals.provide_ids(ids)
    packer = Packer()
    answer: dict[str, Any] = {"value": None, "departs": []}
    before = _options(model)
    simulation.watch_next_run()
    with reporting_errors(answer), own_globals.set_model_and_data(model, data):
        collect, departs = calls.adapt_collector(function, model, fields["duration_s"], ids)
        answer["departs"] = [*departs, *own_globals.globals_read_instead(function, (calls.MODEL,))]
        answer["value"] = packer.node(collect(model, data, fields["duration_s"]))
    answer["changed"] = [name for name, value in _options(model).items() if not np.array_equal(value, before[name])]
    return answer, packer.arrays | {f"first_{name}": value for name, value in simulation.watched_run().items()}


def replay(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Step a model from a given state, in a worker without student code, to test what a student's process reported of a run.

    Parameters
    ----------
    fields : ``model`` (XML text), ``steps``
    arrays : ``qpos`` (nq,), ``qvel`` (nv,), ``gravity`` (3,), ``timestep`` (1,), ``force``: MuJoCo's `qfrc_applied` and
        `xfrc_applied` joined; ``set_at`` (m,): the steps before which the state is set to ``set_qpos``, ``set_qvel``, ``set_force``

    Returns
    -------
    array ``sensordata`` (steps, n), after each step.
    """
    return {}, {"sensordata": np.array([np.array(data.sensordata) for _, data in _replayed_steps(fields, arrays)])}


def read_along(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Call the student's `get_imu_readings` after each step of a replayed run, to compare its values with the recorded rows.

    Parameters
    ----------
    fields : ``path`` (the student's file), ``model`` (XML text), ``steps`` (how many), ``accel_id``, ``gyro_id``
    arrays : the start of the run and later changes of its state, named as for `replay`

    Returns
    -------
    array ``rows`` (steps, 6), NaN where no two vectors came; fewer rows if the function raised
    """
    reader = submission.find("get_imu_readings", fields["path"])
    answer: dict[str, Any] = {}
    rows: list[np.ndarray] = []
    with reporting_errors(answer):
        reading_of = calls.Reader(reader)
        for model, data in _replayed_steps(fields, arrays):
            rows.append(_six_numbers(reading_of(model, data, fields["accel_id"], fields["gyro_id"])))
    return answer, {"rows": np.array(rows).reshape(-1, 6)}


def _replayed_steps(fields: dict[str, Any], arrays: dict[str, Any]) -> Iterator[tuple[Any, Any]]:
    """Yield model and data after each step of a run; set the state before the steps in ``set_at``."""
    import mujoco

    model = model_of(fields["model"])
    model.opt.timestep, model.opt.gravity[:] = float(arrays["timestep"][0]), arrays["gravity"]
    data = mujoco.MjData(model)
    starts = {0: tuple(arrays[name] for name in ("qpos", "qvel", "force"))}
    changes = zip(*(arrays[name] for name in ("set_at", "set_qpos", "set_qvel", "set_force")), strict=True)
    starts |= {int(step): tuple(state) for step, *state in changes}
    with own_globals.set_model_and_data(model, data):
        for step in range(fields["steps"]):
            if step in starts:
                data.qpos[:], data.qvel[:], force = starts[step]
                data.qfrc_applied[:], data.xfrc_applied[:] = force[: model.nv], force[model.nv :].reshape(-1, 6)
            mujoco.mj_step(model, data)
            yield model, data


def _six_numbers(reading: Any) -> np.ndarray:
    try:
        return numbers(reading).reshape(6)
    except (TypeError, ValueError):
        return np.full(6, np.nan)


def _options(model: Any) -> dict[str, np.ndarray]:
    values = {
        "opt.timestep": model.opt.timestep,
        "opt.gravity": model.opt.gravity,
        "opt.integrator": model.opt.integrator,
        "opt.disableflags": model.opt.disableflags,
        "body_mass": model.body_mass,
        "dof_damping": model.dof_damping,
        "jnt_stiffness": model.jnt_stiffness,
        "geom_friction": model.geom_friction,
    }
    return {name: np.array(value, dtype=np.float64) for name, value in values.items()}


# --- the plot ------------------------------------------------------------------------------------------------------------


def plot(fields: dict[str, Any], arrays: dict[str, Any]) -> Reply:
    """Call the student's `plot_imu_data` with the given data; report what it drew and saved.

    Parameters
    ----------
    fields : ``path``; ``keys``: the submission's name of each series -> the name in `arrays`; ``recorder``: None to plot a dict of
        these series; else they are put into a result of the student's `simulate_and_collect`, to plot it in its own form:
        ``path``, ``model``, ``accel_id``, ``gyro_id`` of that call, and ``shows``: names in `arrays` of the time, accel and gyro
        that its steps measure in place of a simulation
    arrays : the plotted data; a number is an array without dimensions

    Returns
    -------
    ``figures`` : what it drew; ``given`` : a description of that result; None without a recorder, or if recording raised
    """
    function = submission.find("plot_imu_data", fields["path"])
    recorder.RECORDER.take(submission.STATE.folder)
    for name in saved.written_pictures(submission.STATE.folder):
        Path(submission.STATE.folder, name).unlink()  # what an import or a script drew is not what this call draws
    answer: dict[str, Any] = {"departs": [], "given": None}
    packer = Packer("given")
    given: Any = {
        name: arrays[key].copy() if arrays[key].ndim else float(arrays[key]) for name, key in fields["keys"].items()
    }
    with reporting_errors(answer):
        way = plan_call(function, calls.PLOTTER)
        recorded = given
        if fields["recorder"]:
            recorded = _recorded(fields["recorder"], arrays, given)
            answer["given"] = packer.node(recorded)
        with own_globals.set_recording(recorded, function, calls.PLOTTER[:4]) as read_instead:
            answer["departs"] = [*way.departs, *read_instead]
            way(function, calls.PLOT_TEXTS | given | {"imu_data": recorded})
    seen, facts = recorder.RECORDER.take(submission.STATE.folder)
    return answer | seen, facts | packer.arrays


def _recorded(recorder: dict[str, Any], arrays: dict[str, Any], series: dict[str, Any]) -> Any:
    """Return what the student's `simulate_and_collect` returns, in its own form, if the sensors measure these series.

    If it alters what it reads, the given series replace its own series of the same form.
    """
    function = submission.find("simulate_and_collect", recorder["path"])
    model, data = simulation_of(recorder["model"])
    ids = {"accel": recorder["accel_id"], "gyro": recorder["gyro_id"]}
    own_globals.provide_ids(ids)
    time, *rows = (arrays[key] for key in recorder["shows"])
    model.opt.timestep = time[0]
    collect, _ = calls.adapt_collector(function, model, time[-1], ids)
    measured = {int(model.sensor_adr[id_]): of_sensor for id_, of_sensor in zip(ids.values(), rows, strict=True)}
    with _measuring(time, measured), own_globals.set_model_and_data(model, data):
        recorded = collect(model, data, time[-1])
    for name, value in series.items():
        with suppress(TypeError, KeyError, IndexError, ValueError, AttributeError):
            _replace(recorded, name, value)
    return recorded


@contextmanager
def _measuring(time: np.ndarray, measured: dict[int, np.ndarray]) -> Iterator[None]:
    """Make each step measure the next row (n, 3) at each sensor address, in place of a simulation; nothing moves."""
    import mujoco

    steps = 0

    def mj_step(model: Any, data: Any, nstep: int = 1) -> None:
        nonlocal steps
        steps += nstep
        mj_forward(model, data)
        data.time = time[min(steps, len(time)) - 1]

    def mj_forward(model: Any, data: Any) -> None:
        for address, rows in measured.items():
            data.sensordata[address : address + 3] = rows[min(max(steps, 1), len(rows)) - 1]

    really = {name: getattr(mujoco, name) for name in ("mj_step", "mj_forward")}
    instead = {"mj_step": mj_step, "mj_forward": mj_forward}
    with ExitStack() as stack:
        for owner in (mujoco, *submission.STATE.modules.values()):
            there = {
                name: instead[own] for own, it in really.items() for name, v in list(vars(owner).items()) if v is it
            }
            stack.enter_context(replaced(owner, there))
        yield


def _replace(recorded: Any, name: str, value: Any) -> None:
    """Replace a recorded series by a given one of the same form: under a key, or as an attribute, also of a frozen object."""
    try:
        own = recorded[name]
    except TypeError:
        if _form(getattr(recorded, name)) == _form(value):
            object.__setattr__(recorded, name, value)
    else:
        if _form(own) == _form(value):
            recorded[name] = value


def _form(series: Any) -> tuple[int, tuple[int, ...]]:
    return np.ndim(series), np.shape(series)[1:]
