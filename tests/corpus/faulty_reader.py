"""Faults of Step 2: the reader."""



from __future__ import annotations

from tests.corpus.faults import Faulty
from tests.corpus.pieces import IDS, READ_DIM, edit, lab, listy, verbatim

SHEET_SLICES = (
    "acceleration = data.sensordata[accel_adr:accel_adr+3].copy()",
    "angular_velocity = data.sensordata[gyro_adr:gyro_adr+3].copy()",
)
SHEET_ADDRESSES = ("accel_adr = model.sensor_adr[accel_sensor_id]", "gyro_adr = model.sensor_adr[gyro_sensor_id]")
SHEET_RETURN = "    return acceleration, angular_velocity\n"


def sheet(*changes: tuple[str, str]) -> dict[str, str]:
    return edit(verbatim(), "imu_reader.py", *changes)


def slices(accel: str, gyro: str) -> dict[str, str]:
    """The sheet with its two slices written otherwise."""
    return sheet((SHEET_SLICES[0], f"acceleration = {accel}"), (SHEET_SLICES[1], f"angular_velocity = {gyro}"))


def after(*lines: str) -> dict[str, str]:
    """The sheet with lines between the reading and the return."""
    return sheet((SHEET_RETURN, "".join(f"    {line}\n" for line in lines) + SHEET_RETURN))


def read(body: str) -> dict[str, str]:
    """A tidy submission whose reader has this body."""
    lines = "".join(f"    {line}\n" for line in body.strip().split("\n"))
    return lab(read="def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):\n" + lines)


def fault(name: str, mistake: str, files: dict[str, str], **more: object) -> Faulty:
    return Faulty(name, mistake, "sensor_access", files, **more)  # type: ignore[arg-type]


DIM_RETURN = "    return data.sensordata[adr:adr + dim].copy()\n"


def tidy_reader(*changes: tuple[str, str]) -> dict[str, str]:
    return lab(read=edit({"r": READ_DIM}, "r", *changes)["r"])


IGNORES_IDS = ("sensor_access.follows_address",)

READER_FAULTS = [
    fault(
        "id-as-slice-start", "sensor-id-as-address",
        slices("data.sensordata[accel_sensor_id:accel_sensor_id+3].copy()", "data.sensordata[gyro_sensor_id:gyro_sensor_id+3].copy()"),
        reason="the id of a sensor is its number in the list, not its place in sensordata",
    ),
    fault(
        "id-called-address", "sensor-id-as-address",
        sheet((SHEET_ADDRESSES[0], "accel_adr = accel_sensor_id"), (SHEET_ADDRESSES[1], "gyro_adr = gyro_sensor_id")),
    ),
    fault("id-in-a-helper", "sensor-id-as-address", tidy_reader(("adr, dim = model.sensor_adr[sensor_id], ", "adr, dim = sensor_id, "))),
    fault(
        "id-times-three", "sensor-id-as-address",
        read("a, g = 3 * accel_sensor_id, 3 * gyro_sensor_id\nreturn data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3].copy()"),
        reason="every sensor is taken to have three numbers",
    ),
    fault(
        "id-as-slice-start-accelerometer-only", "sensor-id-as-address",
        sheet((SHEET_ADDRESSES[0], "accel_adr = accel_sensor_id")), loses=IGNORES_IDS,
        reason="half of a fault costs no more than the whole",
    ),
    fault(
        "id-as-slice-start-gyroscope-only", "sensor-id-as-address",
        sheet((SHEET_ADDRESSES[1], "gyro_adr = gyro_sensor_id")), loses=IGNORES_IDS,
    ),
    fault(
        "copied-line", "same-sensor-twice",
        slices("data.sensordata[accel_adr:accel_adr+3].copy()", "data.sensordata[accel_adr:accel_adr+3].copy()"),
        loses=IGNORES_IDS, reason="values unaltered, of the wrong place",
    ),
    fault("gyroscope-twice", "same-sensor-twice", sheet((SHEET_ADDRESSES[0], "accel_adr = model.sensor_adr[gyro_sensor_id]")), loses=IGNORES_IDS),
    fault("first-six-numbers", "hard-coded-address", read("return data.sensordata[0:3].copy(), data.sensordata[3:6].copy()"), loses=("sensor_access.follows_address",)),
    fault("rotated-the-wrong-way-round", "world-frame", after("turn = data.site_xmat[model.sensor_objid[accel_sensor_id]].reshape(3, 3).T", "acceleration, angular_velocity = turn @ acceleration, turn @ angular_velocity"), loses=("sensor_access.matches_truth",)),
    fault("one-pair-of-arrays-for-all", "view-not-copy", edit(
        read("OUT[0] = data.sensor(accel_sensor_id).data\nOUT[1] = data.sensor(gyro_sensor_id).data\nreturn OUT[0], OUT[1]"), "imu_reader.py",
        ("def get_imu_readings", "OUT = np.zeros((2, 3))\n\n\ndef get_imu_readings"),
    ), loses=("sensor_access.reading_is_a_copy",)),
    fault(
        "fixed-slices", "hard-coded-address", slices("data.sensordata[5:8].copy()", "data.sensordata[11:14].copy()"),
        loses=IGNORES_IDS, reason="right for the torso of the lab model only",
    ),
    fault(
        "fixed-indices", "hard-coded-address",
        read("s = data.sensordata\nreturn np.array([s[5], s[6], s[7]]), np.array([s[11], s[12], s[13]])"), loses=IGNORES_IDS,
    ),
    fault(
        "fixed-names", "hard-coded-address",
        read('return data.sensor("torso_accelerometer").data.copy(), data.sensor("torso_gyroscope").data.copy()'),
        loses=IGNORES_IDS, reason="always reads the torso, whatever ids it is given",
    ),
    fault(
        "ids-looked-up-again", "hard-coded-address",
        lab(
            read="def get_imu_readings(model, data, accel_sensor_id, gyro_sensor_id):\n" + IDS
            + "    a, g = model.sensor_adr[accel_id], model.sensor_adr[gyro_id]\n"
            + "    return data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3].copy()\n"
        ),
        loses=IGNORES_IDS,
    ),
    fault(
        "one-too-late", "off-by-one-address",
        slices("data.sensordata[accel_adr+1:accel_adr+4].copy()", "data.sensordata[gyro_adr+1:gyro_adr+4].copy()"),
    ),
    fault("one-too-early", "off-by-one-address", tidy_reader(("data.sensordata[adr:adr + dim]", "data.sensordata[adr - 1:adr - 1 + dim]"))),
    fault("one-too-late-accelerometer-only", "off-by-one-address", sheet((SHEET_ADDRESSES[0], SHEET_ADDRESSES[0] + " + 1"))),
    fault("returned-in-the-other-order", "swapped-sensors", sheet((SHEET_RETURN, "    return angular_velocity, acceleration\n"))),
    fault(
        "addresses-exchanged", "swapped-sensors",
        read("g, a = (model.sensor_adr[i] for i in (accel_sensor_id, gyro_sensor_id))\n"
             "return data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3].copy()"),
    ),
    fault(
        "slices-not-copied", "view-not-copy", slices("data.sensordata[accel_adr:accel_adr+3]", "data.sensordata[gyro_adr:gyro_adr+3]"),
        loses=("sensor_access.reading_is_a_copy",), reason="the array that came back changes with the next step",
    ),
    fault(
        "asarray-is-no-copy", "view-not-copy", tidy_reader((DIM_RETURN, "    return np.asarray(data.sensordata[adr:adr + dim])\n")),
        loses=("sensor_access.reading_is_a_copy",),
    ),
    fault(
        "accessor-not-copied", "view-not-copy", read("return data.sensor(accel_sensor_id).data, data.sensor(gyro_sensor_id).data"),
        loses=("sensor_access.reading_is_a_copy",),
    ),
    fault(
        "two-components", "wrong-length",
        slices("data.sensordata[accel_adr:accel_adr+2].copy()", "data.sensordata[gyro_adr:gyro_adr+2].copy()"), also=("wrong-return-type",),
    ),
    fault("four-components", "wrong-length", tidy_reader(("data.sensordata[adr:adr + dim]", "data.sensordata[adr:adr + dim + 1]")), also=("wrong-return-type",)),
    fault("norms-only", "wrong-length", after("acceleration = np.linalg.norm(acceleration)", "angular_velocity = np.linalg.norm(angular_velocity)"), also=("wrong-return-type",)),
    fault("acceleration-negated", "sign-flipped", after("acceleration = -acceleration")),
    fault("z-negated", "sign-flipped", read("a, g = model.sensor_adr[[accel_sensor_id, gyro_sensor_id]]\n"
                                            "acc, gyr = data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3].copy()\n"
                                            "acc[2] *= -1   # gravity should be positive\nreturn acc, gyr")),
    fault("both-negated", "sign-flipped", tidy_reader((DIM_RETURN, "    return -data.sensordata[adr:adr + dim]\n"))),
    fault("gravity-added-to-z", "gravity-removed", after("acceleration[2] += 9.81  # remove gravity")),
    fault("gravity-vector-taken-away", "gravity-removed", after("acceleration = acceleration - np.array([0, 0, -9.81])")),
    fault("model-gravity-taken-away", "gravity-removed", read("a, g = model.sensor_adr[[accel_sensor_id, gyro_sensor_id]]\n"
                                                              "return data.sensordata[a:a + 3] - model.opt.gravity, data.sensordata[g:g + 3].copy()")),
    fault("acceleration-in-g", "wrong-units", after("acceleration /= 9.81")),
    fault("rates-in-degrees", "wrong-units", after("angular_velocity = np.degrees(angular_velocity)")),
    fault("rates-in-degrees-by-factor", "wrong-units", read("a, g = model.sensor_adr[[accel_sensor_id, gyro_sensor_id]]\n"
                                                            "return data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3] * 57.29577951308232")),
    fault("components-reversed", "axes-permuted", tidy_reader((DIM_RETURN, "    return data.sensordata[adr:adr + dim][::-1].copy()\n"))),
    fault("x-and-y-exchanged", "axes-permuted", after("acceleration = acceleration[[1, 0, 2]]", "angular_velocity = angular_velocity[[1, 0, 2]]")),
    fault(
        "rotated-into-the-world", "world-frame",
        after("R = data.site_xmat[model.sensor_objid[accel_sensor_id]].reshape(3, 3)", "acceleration = R @ acceleration", "angular_velocity = R @ angular_velocity"),
    ),
    fault(
        "rotated-by-the-site-of-the-torso", "world-frame",
        read("a, g = model.sensor_adr[[accel_sensor_id, gyro_sensor_id]]\n"
             "to_world = data.site_xmat[model.sensor_objid[accel_sensor_id]].reshape(3, 3)\n"
             "return to_world @ data.sensordata[a:a + 3], data.sensordata[g:g + 3].copy()"),
        reason="the accelerometer only",
    ),
    fault("state-of-the-free-joint", "not-the-sensor", read("return data.qacc[0:3].copy(), data.qvel[3:6].copy()")),
    fault("body-velocities", "not-the-sensor", read('body = model.site_bodyid[model.sensor_objid[accel_sensor_id]]\nreturn data.cacc[body, 3:].copy(), data.cvel[body, :3].copy()')),
    fault("steps-while-reading", "disturbs-simulation", after("mujoco.mj_step(model, data)"), loses=("sensor_access.leaves_simulation_alone",)),
    fault(
        "clears-what-it-read", "disturbs-simulation", after("data.sensordata[accel_adr:accel_adr+3] = 0"),
        loses=("sensor_access.leaves_simulation_alone",),
    ),
    fault("resets-after-reading", "disturbs-simulation", read("a, g = model.sensor_adr[[accel_sensor_id, gyro_sensor_id]]\n"
                                                              "out = data.sensordata[a:a + 3].copy(), data.sensordata[g:g + 3].copy()\n"
                                                              "mujoco.mj_resetData(model, data)\nreturn out"),
          loses=("sensor_access.leaves_simulation_alone",)),
    fault(
        "first-reading-kept", "cached-reading",
        tidy_reader(
            ("def get_imu_readings(", "_first = None\n\n\ndef get_imu_readings("),
            ("    return read_sensor(model, data, accel_sensor_id), read_sensor(model, data, gyro_sensor_id)\n",
             "    global _first\n    if _first is None:\n"
             "        _first = read_sensor(model, data, accel_sensor_id), read_sensor(model, data, gyro_sensor_id)\n"
             "    return _first[0].copy(), _first[1].copy()\n"),
        ),
    ),
    fault(
        "cached-by-ids", "cached-reading",
        read("cache = get_imu_readings.__dict__\nkey = str((accel_sensor_id, gyro_sensor_id))\nif key not in cache:\n"
             "    cache[key] = [data.sensor(i).data.copy() for i in (accel_sensor_id, gyro_sensor_id)]\nreturn tuple(v.copy() for v in cache[key])"),
    ),
    fault("rounded-to-two-places", "precision-lost", after("acceleration = np.round(acceleration, 2)", "angular_velocity = np.round(angular_velocity, 2)")),
    fault("cut-to-integers", "precision-lost", tidy_reader((DIM_RETURN, "    return data.sensordata[adr:adr + dim].astype(int)\n"))),
    fault("one-stacked-array", "wrong-return-type", sheet((SHEET_RETURN, "    return np.concatenate([acceleration, angular_velocity])\n")), also=("wrong-length",)),
    fault("a-dictionary", "wrong-return-type", sheet((SHEET_RETURN, "    return {'accel': acceleration, 'gyro': angular_velocity}\n"))),
    fault("printed-not-returned", "wrong-return-type", sheet((SHEET_RETURN, "    print(acceleration, angular_velocity)\n"))),
    fault("reader-gives-nan", "not-finite", after("acceleration = acceleration / 0 * 0", "angular_velocity = angular_velocity * np.nan")),
    fault("misspelt-in-reader", "raises", sheet((SHEET_SLICES[0], "acceleration = data.sensor_data[accel_adr:accel_adr+3].copy()"))),
    fault("index-beyond-the-end", "raises", read("a, g = model.sensor_adr[accel_sensor_id], model.sensor_adr[gyro_sensor_id]\n"
                                                 "return np.array([data.sensordata[a + k * 40] for k in range(3)]), data.sensordata[g:g + 3].copy()"), also=("index-out-of-bounds",)),
    fault("reader-under-another-name", "name-missing", edit(edit(listy(), "imu_reader.py", ("def get_imu_readings(", "def read_imu("), ("get_imu_readings(model, data, accel_id, gyro_id)", "read_imu(model, data, accel_id, gyro_id)")), "noisy_imu.py", ("from imu_reader import MODEL_PATH, get_imu_readings", "from imu_reader import MODEL_PATH, read_imu"), ("get_imu_readings(self.model", "read_imu(self.model"))),
    fault("waits-for-ever-in-reader", "never-returns", read("while not np.any(data.qfrc_applied):\n    pass\nreturn data.sensordata[5:8].copy(), data.sensordata[11:14].copy()")),
    fault("exits-in-reader", "kills-its-process", read("import os\nos._exit(0)")),
]

