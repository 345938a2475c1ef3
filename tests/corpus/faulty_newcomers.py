"""Faults in odd code forms, written against the list of mistakes alone, after the checks."""



from __future__ import annotations

from tests.corpus.faults import Faulty
from tests.corpus.pieces import COLLECT_LOOKUP, PLOT_LOOP, edit, lab, listy, looping, tidy, verbatim

_READ = "def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):\n"
_STEP_READ = "        mujoco.mj_step(model, data)\n        time[i] = data.time\n        acceleration[i], angular_velocity[i] = get_imu_readings(model, data, accel_id, gyro_id)\n"
_RESET, _PUSH = "    mujoco.mj_resetData(model, data)\n", "    data.qvel[0] = 0.5\n"
_STEPS = "int(round(duration_seconds / model.opt.timestep))"
_SIGNATURE = "accel_bias=None, gyro_bias=None, rng=None):"
_STATE, _UPDATE = "None if initial_value is None else np.array(initial_value, dtype=float)", "self.state = self.state + self.alpha * (x - self.state)"


def _reader(name: str, mistake: str, body: str, **more: object) -> Faulty:
    lines = "".join(f"    {line}\n" for line in body.strip().split("\n"))
    return Faulty(name, mistake, "sensor_access", lab(read=_READ + lines), **more)  # type: ignore[arg-type]


def _collect(name: str, mistake: str, *changes: tuple[str, str], **more: object) -> Faulty:
    return Faulty(name, mistake, "data_collection", lab(collect=edit({"c": COLLECT_LOOKUP}, "c", *changes)["c"]), **more)  # type: ignore[arg-type]


def _plot(name: str, mistake: str, *changes: tuple[str, str], **more: object) -> Faulty:
    return Faulty(name, mistake, "visualization", lab(plot=edit({"p": PLOT_LOOP}, "p", *changes)["p"]), **more)  # type: ignore[arg-type]


def _noise(name: str, mistake: str, *changes: tuple[str, str], **more: object) -> Faulty:
    return Faulty(name, mistake, "noise_model", edit(tidy(), "noisy_imu.py", *changes), **more)  # type: ignore[arg-type]


def _filter(name: str, mistake: str, *changes: tuple[str, str], **more: object) -> Faulty:
    return Faulty(name, mistake, "filtering", edit(tidy(), "filters.py", *changes), **more)  # type: ignore[arg-type]


NEWCOMER_FAULTS = [
    _reader("indices-from-the-id", "sensor-id-as-address",
            "take = lambda i: data.sensordata[np.arange(i, i + 3)]\nreturn take(accel_sensor_id), take(gyro_sensor_id)"),
    _reader("reshaped-and-not-copied", "view-not-copy",
            "a, g = (int(model.sensor_adr[i]) for i in (accel_sensor_id, gyro_sensor_id))\nreturn data.sensordata[a:a + 3].reshape(-1), np.ravel(data.sensordata[g:g + 3])",
            loses=("sensor_access.reading_is_a_copy",)),
    _reader("rates-in-turns-a-minute", "wrong-units",
            "a, g = model.sensor_adr[accel_sensor_id], model.sensor_adr[gyro_sensor_id]\nreturn data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3] * 60 / (2 * np.pi)"),
    _reader("half-precision", "precision-lost",
            "a, g = model.sensor_adr[accel_sensor_id], model.sensor_adr[gyro_sensor_id]\nreturn data.sensordata[a:a + 3].astype(np.float16), data.sensordata[g:g + 3].astype(np.float16)"),
    Faulty("cached-by-a-decorator", "cached-reading", "sensor_access",
           lab(read="import functools\n\n\n@functools.lru_cache\n" + _READ + "    return data.sensor(accel_sensor_id).data.copy(), data.sensor(gyro_sensor_id).data.copy()\n")),
    _reader("angular-acceleration-of-the-body", "not-the-sensor",
            "body = model.site_bodyid[model.sensor_objid[accel_sensor_id]]\na = model.sensor_adr[accel_sensor_id]\nreturn data.sensordata[a:a + 3].copy(), data.cvel[body, 3:].copy()"),
    _collect("only-the-clock-is-reset", "no-reset", (_RESET, "    data.time = 0.0\n")),
    _collect("pushed-by-a-force", "wrong-perturbation", (_PUSH, "    data.xfrc_applied[1, 0] = 20.0\n"), also=("no-perturbation",)),
    _collect("moved-in-place-of-pushed", "no-perturbation", (_PUSH, "    data.qpos[0] += 0.5\n"), also=("wrong-perturbation",)),
    _collect("time-by-linspace-to-the-end", "time-axis-wrong", ('{"time": time,', '{"time": np.linspace(0, duration_seconds, n_steps),'),
             loses=("data_collection.time_axis",), reason="the stamps are a little too far apart"),
    _collect("ten-steps-at-once", "samples-skipped", (_STEPS, "int(duration_seconds / model.opt.timestep / 10)"),
             ("mujoco.mj_step(model, data)", "mujoco.mj_step(model, data, nstep=10)")),
    Faulty("one-row-refilled", "aliased-rows", "data_collection",
           edit(listy(), "imu_reader.py", ("    times, accs, gyros = [], [], []\n", "    times, accs, gyros = [], [], []\n    row_a, row_g = np.zeros(3), np.zeros(3)\n"),
                ("        accs.append(acc)\n        gyros.append(gyro)\n", "        row_a[:], row_g[:] = acc, gyro\n        accs.append(row_a)\n        gyros.append(row_g)\n"))),
    _collect("flattened", "wrong-return-type", ('"acceleration": acceleration,', '"acceleration": acceleration.flatten(),')),
    _plot("every-curve-the-same-name", "no-legend", ('label=f"$a_{axis}$"', 'label="a"'), ('label=rf"$\\omega_{axis}$"', 'label="w"')),
    Faulty("saved-before-the-gyroscope", "curves-missing", "visualization",
           edit(looping(), "imu_reader.py", ("    # Gyroscope plot\n", "    plt.savefig('imu_data.png', dpi=150)\n    plt.close()\n    return\n"))),
    _plot("legend-from-z-to-x", "legend-order-wrong", ('ax.legend(loc="best")', 'ax.legend(["z", "y", "x"])')),
    _plot("units-left-in-a-comment", "no-units", ("Acceleration [m/s^2]", "Acceleration"), ("Angular velocity [rad/s]", "Angular velocity"), ("Time [s]", "Time")),
    _noise("bias-drawn-in-the-signature", "bias-not-random",
           (_SIGNATURE, "accel_bias=np.random.normal(0, 0.1, 3), gyro_bias=np.random.normal(0, 0.01, 3), rng=None):"), loses=("noise_model.default_bias",)),
    _filter("history-in-a-default-argument", "shared-state",
            ("alpha=0.1, initial_value=None):", "alpha=0.1, initial_value=None, state=[]):"),
            (f"self.state = {_STATE}", "self.box = state\n        if initial_value is not None:\n            self.box[:] = [np.array(initial_value, dtype=float)]"),
            ("if self.state is None:\n            self.state = x", "if not self.box:\n            self.box.append(x)"),
            (_UPDATE, "self.box[0] = self.box[0] + self.alpha * (x - self.box[0])"), ("return self.state.copy()", "return self.box[0].copy()")),
    _filter("alpha-from-a-time-constant", "alpha-ignored", ("self.alpha = alpha", "dt, tau = 0.002, 0.02\n        self.alpha = dt / (tau + dt)")),
    _filter("z-axis-only", "axes-mixed", (_UPDATE, "self.state = np.array([x[0], x[1], self.state[2] + self.alpha * (x[2] - self.state[2])])")),
    Faulty("comparison-names-exchanged", "legend-order-wrong", "visualization",
           edit(verbatim(), "filters.py", ("label='Raw Z-acceleration'", "label='Filtered Z-acceleration'"), ("label='Filtered Z-acceleration'", "label='Raw Z-acceleration'")),
           loses=("visualization.comparison_plot",)),
]
