"""A part with another interface than the sheet's, and everything else written for it: it costs the part, and nothing else."""

from __future__ import annotations

from tests.corpus.faults import Faulty
from tests.corpus.pieces import COLLECT_LOOKUP, edit, lab, noise_file

_COLLECT = "        acceleration[i], angular_velocity[i] = get_imu_readings(model, data, accel_id, gyro_id)\n"
_NOISE = "        accel, gyro = get_imu_readings(self.model, self.data, self.accel_id, self.gyro_id)\n"


def _reader(name: str, mistake: str, parameters: str, body: str, use: str, *, also: tuple[str, ...] = ()) -> Faulty:
    """`use` is how the reader is called: with `model`, `data`, `accel_id` and `gyro_id`, and its two values in a tuple."""
    read = f"def get_imu_readings({parameters}):\n" + "".join(f"    {line}\n" for line in body.split("\n"))
    collect = edit({"c": COLLECT_LOOKUP}, "c", (_COLLECT, f"        acceleration[i], angular_velocity[i] = {use}\n"))["c"]
    names = "        model, data, accel_id, gyro_id = self.model, self.data, self.accel_id, self.gyro_id\n"
    noise = edit({"n": noise_file()}, "n", (_NOISE, f"{names}        accel, gyro = {use}\n"))["n"]
    return Faulty(name, mistake, "sensor_access", lab(read=read, collect=collect) | {"noisy_imu.py": noise}, also=also)  # type: ignore[arg-type]


_ADDRESSES = "a, g = model.sensor_adr[accel_sensor_id], model.sensor_adr[gyro_sensor_id]\n"
_SLICES = "data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3].copy()"
_IDS = "model, data, accel_sensor_id, gyro_sensor_id"
_CALL = "get_imu_readings(model, data, accel_id, gyro_id)"

INTERFACE_FAULTS = [
    _reader("everyone-expects-the-gyroscope-first", "swapped-sensors", _IDS, f"{_ADDRESSES}return tuple(reversed(({_SLICES})))",
            f"reversed({_CALL})"),
    _reader("everyone-expects-a-dictionary", "wrong-return-type", _IDS, f"{_ADDRESSES}return dict(zip('ag', ({_SLICES})))",
            f"(lambda reading: (reading['a'], reading['g']))({_CALL})"),
    _reader("everyone-expects-six-numbers", "wrong-length", _IDS, f"{_ADDRESSES}return np.concatenate([{_SLICES}])",
            f"np.split({_CALL}, 2)", also=("wrong-return-type",)),
    _reader("everyone-gives-the-data-first", "other-parameters", "data, model, accel_sensor_id, gyro_sensor_id", f"{_ADDRESSES}return {_SLICES}",
            "get_imu_readings(data, model, accel_id, gyro_id)"),
    _reader("everyone-gives-addresses", "sensor-id-as-address", "model, data, a, g", f"return {_SLICES}",
            "get_imu_readings(model, data, model.sensor_adr[accel_id], model.sensor_adr[gyro_id])"),
    _reader("everyone-gives-names", "other-parameters", "model, data, accel_name, gyro_name",
            "a, g = (mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name) for name in (accel_name, gyro_name))\n"
            "a, g = model.sensor_adr[a], model.sensor_adr[g]\n" f"return {_SLICES}",
            "get_imu_readings(model, data, model.sensor(accel_id).name, model.sensor(gyro_id).name)"),
    _reader("everyone-gives-no-ids", "hard-coded-address", "model, data",
            "return data.sensor('torso_accelerometer').data.copy(), data.sensor('torso_gyroscope').data.copy()",
            "get_imu_readings(model, data)"),
    _reader("everyone-gives-no-ids-and-the-first-sensors-are-read", "hard-coded-address", "model, data",
            "return data.sensordata[0:3].copy(), data.sensordata[3:6].copy()", "get_imu_readings(model, data)"),
]  # fmt: skip
