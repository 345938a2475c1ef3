"""Faulty submissions: one fault each, pairs of faults, and faults that look like others."""



from __future__ import annotations

from tests.corpus.faults import Faulty, Pair
from tests.corpus.faulty_collect import COLLECT_FAULTS
from tests.corpus.faulty_files import FILE_FAULTS
from tests.corpus.faulty_filter import FILTER_FAULTS
from tests.corpus.faulty_interfaces import INTERFACE_FAULTS
from tests.corpus.faulty_newcomers import NEWCOMER_FAULTS
from tests.corpus.faulty_noise import NOISE_FAULTS
from tests.corpus.faulty_plot import PLOT_FAULTS
from tests.corpus.faulty_reader import READER_FAULTS
from tests.corpus.pieces import edit, lab, listy, looping, tidy, verbatim
from tests.corpus.sound_figures import PLOT_DEGREES

FAULTY: list[Faulty] = [*READER_FAULTS, *COLLECT_FAULTS, *PLOT_FAULTS, *NOISE_FAULTS, *FILTER_FAULTS, *FILE_FAULTS, *NEWCOMER_FAULTS, *INTERFACE_FAULTS]

_SHEET_READER_END = "    return acceleration, angular_velocity\n"
_TIDY_READ = "return data.sensordata[adr:adr + dim].copy()"
_RESET = "    mujoco.mj_resetData(model, data)\n"
_PUSH = "    data.qvel[0] = 0.5\n"
_READ = "def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):\n"
_STEP = "self.state = self.state + self.alpha * (x - self.state)"
_START = "None if initial_value is None else np.array(initial_value, dtype=float)"
_NOISE_A, _NOISE_G = (f"self.rng.normal(0.0, self.{s}_noise_std, size=3)" for s in ("accel", "gyro"))
_VIEWS = ("data.sensor(accel_sensor_id).data.copy(), data.sensor(gyro_sensor_id).data.copy()", "data.sensor(accel_sensor_id).data, data.sensor(gyro_sensor_id).data")


def _two_files(files: dict[str, str], *edits: tuple[str, tuple[str, str]]) -> dict[str, str]:
    for path, change in edits:
        files = edit(files, path, change)
    return files


PAIRS: list[Pair] = [
    Pair("id-and-no-copy", (("sensor-id-as-address", "sensor_access"), ("view-not-copy", "sensor_access")),
         lab(read=_READ + "    a, g = accel_sensor_id, gyro_sensor_id\n    return data.sensordata[a:a + 3], data.sensordata[g:g + 3]\n")),
    Pair("swapped-and-in-degrees", (("swapped-sensors", "sensor_access"), ("wrong-units", "sensor_access")),
         edit(verbatim(), "imu_reader.py", (_SHEET_READER_END, "    return np.rad2deg(angular_velocity), acceleration\n"))),
    Pair("gravity-removed-and-rounded", (("gravity-removed", "sensor_access"), ("precision-lost", "sensor_access")),
         edit(verbatim(), "imu_reader.py", (_SHEET_READER_END, "    acceleration[2] += 9.81\n    return acceleration.round(2), angular_velocity.round(2)\n"))),
    Pair("no-reset-no-push", (("no-reset", "data_collection"), ("no-perturbation", "data_collection")), edit(tidy(), "imu_reader.py", (_RESET + _PUSH, ""))),
    Pair("milliseconds-and-transposed", (("time-axis-wrong", "data_collection"), ("arrays-transposed", "data_collection")),
         edit(listy(), "imu_reader.py", ("time=np.array(times), acceleration=np.array(accs), angular_velocity=np.array(gyros)", "time=1000 * np.array(times), acceleration=np.array(accs).T, angular_velocity=np.array(gyros).T"))),
    Pair("lag-and-wrong-push", (("read-before-step", "data_collection"), ("wrong-perturbation", "data_collection")),
         edit(listy(), "imu_reader.py", (_PUSH, "    data.qvel[0] = 1.5\n"), ("        mujoco.mj_step(model, data)\n        acc, gyro = get_imu_readings(model, data, accel_id, gyro_id)\n", "        acc, gyro = get_imu_readings(model, data, accel_id, gyro_id)\n        mujoco.mj_step(model, data)\n"))),
    Pair("no-units-no-legend", (("no-units", "visualization"), ("no-legend", "visualization")),
         edit(tidy(), "imu_reader.py", ("[m/s^2]", ""), ("[rad/s]", ""), ("Time [s]", "Time"), ('        ax.legend(loc="best")\n', ""))),
    Pair("no-title-and-x-only-index", (("no-title", "visualization"), ("x-not-time", "visualization")),
         edit(tidy(), "imu_reader.py", ('    top.set_title("Torso accelerometer")\n', ""), ('    bottom.set_title("Torso gyroscope")\n', ""), ('    t = imu_data["time"]\n', '    t = range(len(imu_data["time"]))\n'))),
    Pair("variance-and-no-bias", (("variance-as-std", "noise_model"), ("no-bias", "noise_model")),
         edit(tidy(), "noisy_imu.py", ("self.accel_bias + " + _NOISE_A, "self.rng.normal(0.0, self.accel_noise_std ** 2, size=3)"), ("self.gyro_bias + " + _NOISE_G, "self.rng.normal(0.0, self.gyro_noise_std ** 2, size=3)"))),
    Pair("one-number-and-uniform", (("same-noise-on-axes", "noise_model"), ("not-gaussian", "noise_model")),
         edit(tidy(), "noisy_imu.py", (_NOISE_A, "self.rng.uniform(-1.7320508, 1.7320508) * self.accel_noise_std"), (_NOISE_G, "self.rng.uniform(-1.7320508, 1.7320508) * self.gyro_noise_std"))),
    Pair("swapped-weights-from-zero", (("alpha-swapped", "filtering"), ("zero-initial-state", "filtering")),
         edit(tidy(), "filters.py", (_STEP, "self.state = self.alpha * self.state + (1 - self.alpha) * x"), (_START, "np.zeros(3) if initial_value is None else np.array(initial_value, dtype=float)"))),
    Pair("shared-and-aliased", (("shared-state", "filtering"), ("aliased-output", "filtering")),
         edit(verbatim(), "filters.py", ("    def __init__(self, alpha=0.1", "    value = None\n\n    def __init__(self, alpha=0.1"), ("        self.value = initial_value\n", "        if initial_value is not None:\n            LowPassFilter.value = initial_value\n"),
              ("self.value = measurement.copy()", "LowPassFilter.value = measurement.copy()"), ("            self.value = self.alpha * measurement + (1 - self.alpha) * self.value\n        return self.value.copy()\n", "            LowPassFilter.value = self.alpha * measurement + (1 - self.alpha) * self.value\n        return self.value\n"))),
    Pair("id-and-no-reset", (("sensor-id-as-address", "sensor_access"), ("no-reset", "data_collection")),
         edit(verbatim(), "imu_reader.py", ("accel_adr = model.sensor_adr[accel_sensor_id]", "accel_adr = accel_sensor_id"), ("gyro_adr = model.sensor_adr[gyro_sensor_id]", "gyro_adr = gyro_sensor_id"), ("    mujoco.mj_resetData(model, data)\n", ""))),
    Pair("view-and-aliased-rows", (("view-not-copy", "sensor_access"), ("aliased-rows", "data_collection")),
         edit(listy(), "imu_reader.py", _VIEWS, ("        accs.append(acc)\n", '        accs.append(data.sensor("torso_accelerometer").data)\n'), ("        gyros.append(gyro)\n", '        gyros.append(data.sensor("torso_gyroscope").data)\n'))),
    Pair("world-frame-and-no-noise", (("world-frame", "sensor_access"), ("no-noise", "noise_model")),
         _two_files(lab(read=_READ + "    a, g = model.sensor_adr[[accel_sensor_id, gyro_sensor_id]]\n    R = data.site_xmat[model.sensor_objid[accel_sensor_id]].reshape(3, 3)\n    return R @ data.sensordata[a:a + 3], R @ data.sensordata[g:g + 3]\n"),
                    ("noisy_imu.py", (" + " + _NOISE_A, "")), ("noisy_imu.py", (" + " + _NOISE_G, "")))),
    Pair("no-labels-and-alpha-ignored", (("no-axis-labels", "visualization"), ("alpha-ignored", "filtering")),
         _two_files(edit(verbatim(), "imu_reader.py", ("    axes[0].set_ylabel('Acceleration (m/s²)')\n", ""), ("    axes[1].set_xlabel('Time (s)')\n", ""), ("    axes[1].set_ylabel('Angular Velocity (rad/s)')\n", "")),
                    ("filters.py", ("self.alpha = alpha", "self.alpha = 0.1")))),
    Pair("bias-redrawn-and-high-pass", (("bias-redrawn", "noise_model"), ("high-pass", "filtering")),
         _two_files(verbatim(),
                    ("noisy_imu.py", ("        # Add Gaussian noise\n", "        self.accel_bias = np.random.normal(0, 0.1, 3)\n        self.gyro_bias = np.random.normal(0, 0.01, 3)\n")),
                    ("filters.py", ("        return self.value.copy()\n", "        return measurement - self.value\n")))),
]

LOOKALIKES: list[Faulty] = [
    Faulty("views-that-end-in-equal-rows", "view-not-copy", "sensor_access", edit(listy(), "imu_reader.py", _VIEWS), never=("aliased-rows",), loses=("sensor_access.reading_is_a_copy",), reason="the rows are equal because the reader returns views; with a sound reader the recording is sound"),
    Faulty("degrees-not-another-axis", "wrong-units", "sensor_access", edit(verbatim(), "imu_reader.py", (_SHEET_READER_END, "    return acceleration, angular_velocity * 180 / np.pi\n")), never=("axes-permuted", "off-by-one-address")),
    Faulty("another-axis-not-degrees", "axes-permuted", "sensor_access", edit(verbatim(), "imu_reader.py", (_SHEET_READER_END, "    return acceleration, angular_velocity[[2, 0, 1]]\n")), never=("wrong-units", "off-by-one-address")),
    Faulty("g-not-rounded", "wrong-units", "sensor_access", edit(tidy(), "imu_reader.py", (_TIDY_READ, "values = data.sensordata[adr:adr + dim].copy()\n    return values / 9.80665 if model.sensor_type[sensor_id] == mujoco.mjtSensor.mjSENS_ACCELEROMETER else values")), never=("precision-lost", "sign-flipped")),
    Faulty("gravity-of-the-other-sign", "gravity-removed", "sensor_access", edit(verbatim(), "imu_reader.py", (_SHEET_READER_END, "    acceleration[2] -= 9.81\n    return acceleration, angular_velocity\n")), never=("sign-flipped",), reason="subtracting 9.81 gives -19.62 at rest"),
    Faulty("z-flipped-not-gravity-removed", "sign-flipped", "sensor_access", edit(verbatim(), "imu_reader.py", (_SHEET_READER_END, "    acceleration[2] = -acceleration[2]\n    return acceleration, angular_velocity\n")), never=("gravity-removed", "world-frame"), reason="the world's z axis points the other way too, but x and y were not turned"),
    Faulty("head-not-off-by-some", "hard-coded-address", "sensor_access", edit(tidy(), "imu_reader.py", (_TIDY_READ, "return data.sensordata[5:8].copy() if model.sensor_type[sensor_id] == mujoco.mjtSensor.mjSENS_ACCELEROMETER else data.sensordata[11:14].copy()")), never=("off-by-one-address", "sensor-id-as-address"), loses=("sensor_access.follows_address",)),
    Faulty("zero-start-not-wrong-alpha", "zero-initial-state", "filtering", edit(verbatim(), "filters.py", ("self.value = initial_value", "self.value = np.zeros(3) if initial_value is None else initial_value")), never=("alpha-ignored", "alpha-swapped", "gain-not-one")),
    Faulty("wrong-alpha-not-zero-start", "alpha-ignored", "filtering", edit(verbatim(), "filters.py", ("self.alpha = alpha", "self.alpha = 0.05")), never=("zero-initial-state", "alpha-swapped")),
    Faulty("half-gain-at-the-first-sample", "zero-initial-state", "filtering", edit(verbatim(), "filters.py", ("self.value = measurement.copy()", "self.value = self.alpha * measurement + (1 - self.alpha) * np.zeros_like(measurement)")), never=("gain-not-one", "alpha-ignored")),
    Faulty("lag-not-time-axis", "read-before-step", "data_collection", edit(looping(), "imu_reader.py", ("        mujoco.mj_step(model, data)\n        acc, gyro = get_imu_readings(model, data, accel_id, gyro_id)\n", "        acc, gyro = get_imu_readings(model, data, accel_id, gyro_id)\n        mujoco.mj_step(model, data)\n")), never=("time-axis-wrong", "samples-skipped")),
    Faulty("time-axis-not-lag", "time-axis-wrong", "data_collection", edit(tidy(), "imu_reader.py", ("time[i] = data.time", "time[i] = data.time + 5 * model.opt.timestep")), never=("read-before-step", "samples-skipped"), reason="the values are right, the clock is five samples late"),
    Faulty("skipped-not-fast-clock", "samples-skipped", "data_collection", edit(listy(), "imu_reader.py", ("        mujoco.mj_step(model, data)\n", "        mujoco.mj_step(model, data)\n        mujoco.mj_step(model, data)\n")), never=("ignores-duration", "hard-coded-timestep", "read-before-step")),
    Faulty("no-reset-not-wrong-push", "no-reset", "data_collection", edit(looping(), "imu_reader.py", (_RESET, "    data.time = 0.0\n")), never=("wrong-perturbation", "no-perturbation")),
    Faulty("weak-push-not-no-push", "wrong-perturbation", "data_collection", edit(looping(), "imu_reader.py", (_PUSH, "    data.qvel[0] = 0.05\n")), never=("no-perturbation", "no-reset")),
    Faulty("degrees-with-a-label-of-radians", "wrong-data-plotted", "visualization", lab(plot=PLOT_DEGREES.replace("(deg/s)", "(rad/s)")), also=("wrong-units",), never=("panels-swapped",), reason="the numbers are degrees, the label says radians"),
    Faulty("fifth-more-noise-not-variance", "std-ignored", "noise_model", edit(tidy(), "noisy_imu.py", (_NOISE_A, "self.rng.normal(0.0, 0.06, size=3)"), (_NOISE_G, "self.rng.normal(0.0, 0.006, size=3)")), never=("variance-as-std", "stds-swapped")),
    Faulty("redrawn-bias-not-more-noise", "bias-redrawn", "noise_model", edit(tidy(), "noisy_imu.py", ("        accel = accel + self.accel_bias + " + _NOISE_A, "        self.accel_bias = self.rng.normal(0.0, 0.1, 3)\n        self.gyro_bias = self.rng.normal(0.0, 0.01, 3)\n        accel = accel + self.accel_bias + " + _NOISE_A)), also=("bias-argument-ignored",), never=("variance-as-std", "std-ignored", "not-gaussian")),
    Faulty("frozen-not-bias", "frozen-noise", "noise_model", edit(tidy(), "noisy_imu.py", ("        self.gyro_bias = np.asarray(gyro_bias, dtype=float)\n", "        self.gyro_bias = np.asarray(gyro_bias, dtype=float)\n        self.n = self.rng.standard_normal(6)\n"), (_NOISE_A, "self.accel_noise_std * self.n[:3]"), (_NOISE_G, "self.gyro_noise_std * self.n[3:]")), never=("no-noise", "noise-not-zero-mean", "bias-sign-flipped")),
]

__all__ = ["FAULTY", "LOOKALIKES", "PAIRS", "Faulty", "Pair"]
