"""Contents that are no text, and changes of whole submissions: what a row of the corpus names instead of writing it out."""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Mapping
from io import BytesIO

from tests.corpus.pieces import tidy
from tests.corpus.writing import Content, Link, tarred, zipped

GOOD_ZIP = zipped(tidy())
WHITE = b"".join(b"\x00" + b"\xff" * (3 * 64) for _ in range(64))


def crlf(text: str) -> str:
    return text.replace("\n", "\r\n")


def tabs(text: str) -> str:
    """Return the text indented with tabs: four spaces at the start of a line become one."""
    return re.sub(r"^(?: {4})+", lambda spaces: "\t" * (len(spaces[0]) // 4), text, flags=re.MULTILINE)


def png(width: int, height: int, rows: bytes = b"") -> bytes:
    """Return a PNG that claims a size and holds what it is given."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def nested(levels: int) -> bytes:
    inner = GOOD_ZIP
    for level in range(levels):
        inner = zipped({f"level{level}.zip": inner})
    return inner


def damaged(archive: bytes) -> bytes:
    """Change bytes in the middle of an archive: its directory is whole, a file's checksum is not."""
    middle = archive.index(b"imu_reader.py") + 200
    return archive[:middle] + bytes(byte ^ 0xFF for byte in archive[middle : middle + 64]) + archive[middle + 64 :]


def recorded_rows() -> bytes:
    """Return what a student can record at home: the public lab model, pushed, at several time steps; and the public readings."""
    import mujoco
    import numpy as np

    from grader.labs.imu import bundles
    from reference import worlds

    model = mujoco.MjModel.from_xml_string(worlds.lab())
    reading = bundles.shipped()["reading_lab"]
    timesteps = (0.001, 0.00125, 0.002, 0.0025, 0.004)
    kept: dict[str, np.ndarray] = {
        "timesteps": np.array(timesteps),
        "lab": np.array(worlds.lab()),
        "read_states": np.hstack([reading["qpos"], 0.1 * reading["qvel"]]),
        "read_sensors": reading["sensordata"],
    }
    for timestep in timesteps:
        model.opt.timestep = timestep
        data = mujoco.MjData(model)
        data.qvel[0] = 0.5
        sensors, states = [], []
        for _ in range(round(2.5 / timestep)):
            mujoco.mj_step(model, data)
            sensors.append(np.array(data.sensordata))
            states.append(np.concatenate([data.qpos, 0.1 * data.qvel]))
        kept |= {f"accel_{timestep:g}": np.array(sensors)[:, 5:8], f"gyro_{timestep:g}": np.array(sensors)[:, 11:14]}
        if timestep == 0.002:
            kept["states"] = np.array(states[::5])  # a search through every state would take all of the time
    stream = BytesIO()
    np.savez_compressed(stream, **kept)
    return stream.getvalue()


def zip_bomb() -> bytes:
    """Return a zip of a sound submission and 200 megabytes of zeros; a function of its own, as cases go to other processes."""
    return zipped({**tidy(), "zeros.bin": bytes(200 << 20)})


_OUTSIDE = {"../../outside.py": "print('outside')\n", "/tmp/absolute.py": "x = 1\n"}
MADE: Mapping[str, Content | Callable[[], Content]] = {
    "white picture": png(64, 64, WHITE),
    "picture of 60000 by 60000": png(60000, 60000, WHITE),
    "picture cut short": png(640, 480, WHITE)[:60],
    "empty zip": zipped({}),
    "zip cut short": GOOD_ZIP[: len(GOOD_ZIP) // 2],
    "damaged zip": damaged(GOOD_ZIP),
    "zip in a zip": nested(1),
    "zip in three zips": nested(3),
    "zip bomb": zip_bomb,
    "zip that climbs out": zipped({**tidy(), **_OUTSIDE}),
    "tar cut short": tarred(tidy())[:900],
    "tar with a link": tarred({**tidy(), "evil": Link("../../../etc/passwd")}),
    "text named zip": b"this is no archive\n" * 20,
    "text named tar.gz": b"\x1f\x8b" + b"nothing" * 30,
    "every byte": bytes(range(256)) * 8,
    "recorded rows": recorded_rows,
}
