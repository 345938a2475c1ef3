"""Faults of Step 3: the recording."""



from __future__ import annotations

from tests.corpus.faults import Faulty
from tests.corpus.pieces import COLLECT_APPEND, COLLECT_LOOKUP, PLOT_LOOP, edit, lab, listy, looping, tidy, verbatim


def sheet(*changes: tuple[str, str]) -> dict[str, str]:
    return edit(verbatim(), "imu_reader.py", *changes)


def tidied(*changes: tuple[str, str]) -> dict[str, str]:
    return edit(tidy(), "imu_reader.py", *changes)


def listed(*changes: tuple[str, str]) -> dict[str, str]:
    return edit(listy(), "imu_reader.py", *changes)


def looped(*changes: tuple[str, str]) -> dict[str, str]:
    return edit(looping(), "imu_reader.py", *changes)


def fault(name: str, mistake: str, files: dict[str, str], **more: object) -> Faulty:
    return Faulty(name, mistake, "data_collection", files, **more)  # type: ignore[arg-type]


RESET = "    mujoco.mj_resetData(model, data)\n"
PUSH = "    data.qvel[0] = 0.5\n"
SHEET_PUSH = "    data.qvel[0] = 0.5  # Forward velocity\n"
STEP = "        mujoco.mj_step(model, data)\n"
SHEET_STEP = "        mujoco.mj_step(model, data)\n\n"
SHEET_STORE = "        angular_velocities[i] = gyro\n"
TIDY_STORE = "        acceleration[i], angular_velocity[i] = get_imu_readings(model, data, accel_id, gyro_id)\n"
LIST_READ = "        acc, gyro = get_imu_readings(model, data, accel_id, gyro_id)\n"
TIDY_RETURN = '    return {"time": time, "acceleration": acceleration, "angular_velocity": angular_velocity}\n'

OWN_KEYS = edit(
    {"imu_reader.py": COLLECT_LOOKUP + PLOT_LOOP}, "imu_reader.py",
    (TIDY_RETURN, '    return {"t": time, "acc": acceleration, "gyro": angular_velocity}\n'),
         ('t = imu_data["time"]', 't = imu_data["t"]'),
         ('imu_data["acceleration"][:, k]', 'imu_data["acc"][:, k]'),
         ('imu_data["angular_velocity"][:, k]', 'imu_data["gyro"][:, k]'),
)["imu_reader.py"]

TUPLE = '''\
def plot_imu_data(imu_data):
    t, acc, gyr = imu_data if isinstance(imu_data, tuple) else imu_data.values()
'''

LISTS = "    times, accs, gyros = [], [], []\n"


def kept(main: str = "") -> dict[str, str]:
    """Lists at module level, and what the program records by itself."""
    collect = COLLECT_APPEND.replace(LISTS, "")
    assert collect != COLLECT_APPEND
    return lab(collect=f"times, accs, gyros = [], [], []\n\n\n{collect}", main=main)


MATCHES = ("data_collection.matches_truth",)

COLLECT_FAULTS = [
    fault("gravity-added-to-the-rows", "rows-altered", tidied((TIDY_STORE, TIDY_STORE + "        acceleration[i, 2] += 9.81\n")), loses=MATCHES),
    fault("rates-stored-in-degrees", "rows-altered", listed((LIST_READ, LIST_READ + "        gyro = np.degrees(gyro)\n")), loses=MATCHES),
    fault("velocities-not-reset", "no-reset", tidied((RESET, "    data.qpos[:] = model.qpos0\n    data.time = 0\n")), loses=("data_collection.starts_from_reset",)),
    fault("lists-at-module-level", "keeps-old-rows", kept()),
    fault("lists-at-module-level-recorded-before", "keeps-old-rows", kept("""\
model = mujoco.MjModel.from_xml_path(MODEL_PATH)
for seconds in (0.8, 0.4):
    plot_imu_data(simulate_and_collect(model, mujoco.MjData(model), seconds))
""")),
    fault("lists-in-a-default-argument", "keeps-old-rows", edit(
        lab(collect=COLLECT_APPEND), "imu_reader.py",
        ("duration_seconds=5.0):", "duration_seconds=5.0, times=[], accs=[], gyros=[]):"), (LISTS, ""),
    )),
    fault("reset-forgotten", "no-reset", sheet(("    # Reset simulation\n    mujoco.mj_resetData(model, data)\n\n    # Apply", "    # Apply"))),
    fault("reset-forgotten-tidy", "no-reset", tidied((RESET, ""))),
    fault("only-the-clock-reset", "no-reset", looped((RESET, "    data.time = 0\n"))),
    fault("reset-at-the-end", "no-reset", tidied((RESET, ""), (TIDY_RETURN, RESET + TIDY_RETURN))),
    fault("push-forgotten", "no-perturbation", sheet((SHEET_PUSH, ""))),
    fault("push-wiped-out", "no-perturbation", tidied((RESET + PUSH, PUSH + RESET))),
    fault("push-compared", "no-perturbation", listed((PUSH, "    data.qvel[0] == 0.5\n"))),
    fault("push-ten-times", "wrong-perturbation", sheet((SHEET_PUSH, "    data.qvel[0] = 5.0\n"))),
    fault("push-backwards", "wrong-perturbation", tidied((PUSH, "    data.qvel[0] = -0.5\n"))),
    fault("push-sideways", "wrong-perturbation", looped((PUSH, "    data.qvel[1] = 0.5\n"))),
    fault("push-upwards", "wrong-perturbation", listed((PUSH, "    data.qvel[2] = 0.5\n"))),
    fault("push-as-rotation", "wrong-perturbation", listed((PUSH, "    data.qvel[3] = 0.5\n"))),
    fault("pushed-every-joint", "wrong-perturbation", tidied((PUSH, "    data.qvel[:] = 0.5\n"))),
    fault("pushed-at-every-step", "wrong-perturbation", sheet((SHEET_PUSH, ""), (SHEET_STEP, "        data.qvel[0] = 0.5\n" + SHEET_STEP))),
    fault("moved-not-pushed", "no-perturbation", tidied((PUSH, "    data.qpos[0] = 0.5\n")), also=("wrong-perturbation",)),
    fault("read-then-step", "read-before-step", sheet((SHEET_STEP, ""), (SHEET_STORE, SHEET_STORE + STEP)), also=("rows-left-zero",), reason="the first row is zero: nothing was computed yet"),
    fault("read-then-step-time-after", "read-before-step", tidied((STEP, ""), (TIDY_STORE, ""), ("        time[i] = data.time\n", TIDY_STORE + STEP + "        time[i] = data.time\n"))),
    fault("read-then-step-list", "read-before-step", listed(
        (STEP + LIST_READ, LIST_READ + STEP))),
    fault("views-appended", "aliased-rows", listed(("        accs.append(acc)\n", '        accs.append(data.sensor("torso_accelerometer").data)\n'),
                                                   ("        gyros.append(gyro)\n", '        gyros.append(data.sensor("torso_gyroscope").data)\n'))),
    fault("one-buffer-for-all-rows", "aliased-rows", looped(("    rows = []\n", "    rows = []\n    row = np.zeros(6)\n    times = []\n"),
                                                            ("        rows.append(np.concatenate([[data.time], acc, gyro]))\n", "        row[:3], row[3:] = acc, gyro\n        rows.append(row)\n        times.append(data.time)\n"),
                                                            ("    table = np.vstack(rows)\n", "    table = np.column_stack([times, np.vstack(rows)])\n"))),
    fault("fixed-1500-steps", "ignores-duration", sheet(("n_steps = int(duration_seconds / dt)", "n_steps = 1500"))),
    fault("duration-overwritten", "ignores-duration", tidied(("    n_steps = int(round(", "    duration_seconds = 5.0\n    n_steps = int(round("))),
    fault("until-three-seconds", "ignores-duration", looped(("while data.time < duration_seconds:", "while data.time < 3.0:"))),
    fault("duration-is-steps", "ignores-duration", tidied(("int(round(duration_seconds / model.opt.timestep))", "int(round(duration_seconds * 100))")), also=("hard-coded-timestep",)),
    fault("timestep-of-2-ms", "hard-coded-timestep", sheet(("dt = model.opt.timestep", "dt = 0.002"))),
    fault("500-hertz", "hard-coded-timestep", tidied(("int(round(duration_seconds / model.opt.timestep))", "int(duration_seconds * 500)"))),
    fault("time-from-fixed-step", "hard-coded-timestep", tidied(("time[i] = data.time", "time[i] = (i + 1) * 0.002")), also=("time-axis-wrong",)),
    fault("two-steps-a-sample", "samples-skipped", sheet((SHEET_STEP, STEP + SHEET_STEP))),
    fault("decimated-by-ten", "samples-skipped", tidied(("model.opt.timestep))", "model.opt.timestep / 10))"), (STEP, "        mujoco.mj_step(model, data, nstep=10)\n"))),
    fault("every-fifth-kept", "samples-skipped", listed(("        times.append(data.time)\n        accs.append(acc)\n        gyros.append(gyro)\n",
                                                         "        if _ % 5 == 0:\n            times.append(data.time)\n            accs.append(acc)\n            gyros.append(gyro)\n"))),
    fault("time-is-an-index", "time-axis-wrong", sheet(("times[i] = data.time", "times[i] = i"))),
    fault("time-in-milliseconds", "time-axis-wrong", tidied(("time[i] = data.time", "time[i] = data.time * 1000"))),
    fault("time-up-to-one", "time-axis-wrong", looped(('{"time": table[:, 0],', '{"time": np.linspace(0, 1, len(table)),'))),
    fault("time-of-the-wall-clock", "time-axis-wrong", tidied(("time[i] = data.time", "time[i] = clock.perf_counter()"), ("import numpy as np\n", "import numpy as np\nimport time as clock\n"))),
    fault("time-twice-as-fast", "time-axis-wrong", tidied(("time[i] = data.time", "time[i] = 2 * i * model.opt.timestep"))),
    fault("three-rows", "arrays-transposed", sheet(("'acceleration': accelerations,", "'acceleration': accelerations.T,"), ("'angular_velocity': angular_velocities\n", "'angular_velocity': angular_velocities.T\n"),
                                                   *[(f"imu_data['{k}'][:, {i}]", f"imu_data['{k}'].reshape(-1, 3)[:, {i}] if len(imu_data['{k}']) != 3 else imu_data['{k}'][{i}]") for k in ("acceleration", "angular_velocity") for i in range(3)])),
    fault("three-rows-from-zip", "arrays-transposed", listed(("acceleration=np.array(accs), angular_velocity=np.array(gyros)", "acceleration=np.array(accs).T, angular_velocity=np.array(gyros).T"))),
    fault("own-keys", "wrong-keys", lab(collect=OWN_KEYS, plot="")),
    fault("short-keys", "wrong-keys", sheet(("    return {\n        'time': times,\n        'acceleration': accelerations,\n        'angular_velocity': angular_velocities\n    }", "    return {'time': times, 'accel': accelerations, 'gyro': angular_velocities}"),
                                            *[(f"imu_data['acceleration'][:, {i}]", f"imu_data['accel'][:, {i}]") for i in range(3)],
                                            *[(f"imu_data['angular_velocity'][:, {i}]", f"imu_data['gyro'][:, {i}]") for i in range(3)])),
    fault("keys-with-capitals", "wrong-keys", listed(("dict(time=np.array(times), acceleration=np.array(accs), angular_velocity=np.array(gyros))", '{"Time": np.array(times), "Acceleration": np.array(accs), "Angular Velocity": np.array(gyros)}'),
                                                     ('plt.plot(imu_data["time"], imu_data["acceleration"])', 'plt.plot(imu_data["Time"], imu_data["Acceleration"])'),
                                                     ('plt.plot(imu_data["time"], imu_data["angular_velocity"])', 'plt.plot(imu_data["Time"], imu_data["Angular Velocity"])'))),
    fault("stored-the-wrong-way-round", "channels-swapped", sheet(("accelerations[i] = accel", "accelerations[i] = gyro"), ("angular_velocities[i] = gyro", "angular_velocities[i] = accel"))),
    fault("unpacked-the-wrong-way-round", "channels-swapped", listed(("acc, gyro = get_imu_readings(", "gyro, acc = get_imu_readings("))),
    fault("standing-by-heart", "nothing-simulated", sheet((SHEET_STEP, ""), (SHEET_STORE, "        accelerations[i], angular_velocities[i] = (0.0, 0.0, -9.81), (0.0, 0.0, 0.0)\n        times[i] = (i + 1) * dt\n")), reason="no step is made, and every row is what a robot at rest reads"),
    fault("last-tenth-never-filled", "rows-left-zero", tidied(("for i in range(n_steps):", "for i in range(n_steps - n_steps // 10):"), ("np.empty(n_steps)", "np.zeros(n_steps)"),
                                                              ("acceleration = np.empty((n_steps, 3))", "acceleration = np.zeros((n_steps, 3))"), ("angular_velocity = np.empty((n_steps, 3))", "angular_velocity = np.zeros((n_steps, 3))"))),
    fault("first-row-never-filled", "first-row-empty", sheet(("for i in range(n_steps):", "for i in range(1, n_steps):")), also=("rows-left-zero",), reason="the same numbers as reading before the step, after one step less"),
    fault("stored-behind-the-loop", "only-last-row", sheet(("        accelerations[i] = accel\n" + SHEET_STORE, "    accelerations[i] = accel\n    angular_velocities[i] = gyro\n"))),
    fault("arrays-twice-too-long", "rows-left-zero", sheet(("times = np.zeros(n_steps)", "times = np.zeros(2 * n_steps)"), ("accelerations = np.zeros((n_steps, 3))", "accelerations = np.zeros((2 * n_steps, 3))"),
                                                           ("angular_velocities = np.zeros((n_steps, 3))", "angular_velocities = np.zeros((2 * n_steps, 3))"))),
    fault("own-timestep", "modifies-model", tidied((RESET, "    model.opt.timestep = 0.001\n" + RESET), ("    n_steps = int(round(duration_seconds / model.opt.timestep))", "    n_steps = int(round(duration_seconds / 0.001))"))),
    fault("own-gravity", "modifies-model", sheet((SHEET_PUSH, "    model.opt.gravity[2] = -9.0\n" + SHEET_PUSH))),
    fault("a-tuple-of-arrays", "wrong-return-type", lab(
        collect=COLLECT_LOOKUP.replace(TIDY_RETURN, "    return time, acceleration, angular_velocity\n"),
        plot=PLOT_LOOP.replace('def plot_imu_data(imu_data):\n', TUPLE).replace('    t = imu_data["time"]\n', "").replace('imu_data["acceleration"]', "acc").replace('imu_data["angular_velocity"]', "gyr"),
    )),
    fault("recording-gives-nan", "not-finite", tidied(("    acceleration = np.empty((n_steps, 3))\n", "    acceleration = np.full((n_steps, 3), np.nan)\n"), (TIDY_STORE, "        _, angular_velocity[i] = get_imu_readings(model, data, accel_id, gyro_id)\n"))),
    fault("name-of-another-model", "sensor-not-found", tidied(('"torso_accelerometer")\n    gyro_id', '"imu_accelerometer")\n    gyro_id'), ('mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "torso_gyroscope")', 'mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, "imu_gyro")')), reason="mj_name2id answers -1, which reads the last sensor of the model"),
    fault("name-of-another-model-raises", "sensor-not-found", listed(('model.sensor("torso_accelerometer").id', 'model.sensor("torso_accel").id')), also=("raises",)),
    fault("misspelt-in-recording", "unknown-name", sheet(("angular_velocities[i] = gyro", "angular_velocities[i] = gyr"))),
    fault("recording-raises", "raises", sheet(("    dt = model.opt.timestep\n", "    dt = model.timestep\n"))),
    fault("loop-without-end", "never-returns", looped(("while data.time < duration_seconds:", "while duration_seconds > 0:"))),
    fault("clock-never-moves", "never-returns", looped(("        rows.append(", "        data.time = 0.0\n        rows.append("))),
    fault("exits-in-recording", "kills-its-process", tidied((RESET, "    import os\n    os._exit(1)\n" + RESET))),
    fault("no-recording-function", "name-missing", sheet(("def simulate_and_collect(model, data, duration_seconds=5.0):", "def collect_data(model, data, duration_seconds=5.0):"), ("imu_data = simulate_and_collect(", "imu_data = collect_data("))),
]
