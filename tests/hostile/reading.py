"""Files that attack whoever reads them: each kind that the grader or the sandbox opens has its hostile ones beside a sound submission."""

from __future__ import annotations

import gzip
import io
import json
import struct
import tarfile
import zlib
from collections.abc import Callable
from functools import partial

from tests.corpus.writing import Files, Late, notebook, zipped
from tests.hostile.denying import bomb, picture_bomb
from tests.hostile.forging import BLANK
from tests.hostile.picture import END, canned_picture, head, png
from tests.hostile.program import FILTER, Program, sound

HUGE = 2**63 - 1


def archive(name: str, file: str, data: bytes | Callable[[], bytes]) -> Program:
    """All that is handed in is this archive."""
    return Program(name, "bytes", Late({file: data}), as_="file", only="filtering")


def beside(name: str, more: Files) -> Program:
    """A sound filter with further files, which may cost nothing."""
    return Program(name, "bytes", {FILTER: sound()[FILTER], **more}, only="filtering", keeps=("filtering",))


# ---------------------------------------------------------------- zip


def zip_whose_entries_overlap(entries: int = 2000) -> bytes:
    """Every entry of the table of contents is the same megabyte of zeros, under names of its own."""
    data = zipped({"filters.py": bytes(1 << 20)})
    start = data.index(b"PK\1\2")
    head = data[start : data.index(b"PK\5\6")]
    rows = b"".join(head.replace(b"filters.py", b"%07d.py" % n) for n in range(entries))
    end = struct.pack("<4s4H2IH", b"PK\5\6", 0, 0, entries, entries, len(rows), start, 0)
    return data[:start] + rows + end


def zip_that_claims(size: int) -> bytes:
    data = bytearray(zipped({"filters.py": "x = 1\n", "imu_reader.py": "y = 2\n"}))
    at = data.index(b"PK\1\2") + 20
    data[at : at + 8] = struct.pack("<II", size, size)
    return bytes(data)


ZIPS = [
    archive("zip-whose-entries-overlap", "a.zip", zip_whose_entries_overlap()),
    archive("zip-that-claims-4-gigabytes", "a.zip", zip_that_claims(0xFFFFFFFE)),
    archive("zip-of-names-of-60-kilobytes", "a.zip", lambda: zipped({"d/" * 30_000 + f"{n}.py": "" for n in range(120)})),
    archive("zip-of-nothing-but-its-end", "a.zip", struct.pack("<4s4H2IH", b"PK\5\6", 0, 0, 65_535, 65_535, 0xFFFFFFFF, 0xFFFFFFFF, 0)),
]

# ---------------------------------------------------------------- tar and gzip


def tar_that_claims(size: int, *, pax: bool) -> bytes:
    buffer = io.BytesIO()
    how = tarfile.PAX_FORMAT if pax else tarfile.GNU_FORMAT
    with tarfile.open(fileobj=buffer, mode="w", format=how) as made:
        info = tarfile.TarInfo("noisy_imu.py")
        info.size, info.pax_headers = (0, {"size": str(size)}) if pax else (size, {})
        buffer.write(info.tobuf(how))
        more = tarfile.TarInfo("filters.py")
        more.size = 6
        made.offset = buffer.tell()
        made.addfile(more, io.BytesIO(b"x = 1\n"))
    return buffer.getvalue()


def tar_with_a_sparse_map() -> bytes:
    """An old GNU sparse file whose map goes on for ever."""
    info = tarfile.TarInfo("sparse.py")
    info.type, info.size = tarfile.GNUTYPE_SPARSE, 512
    header = bytearray(info.tobuf(tarfile.GNU_FORMAT))
    header[386 : 386 + 96] = b"00000000000\0" * 8
    header[482], header[483:495] = 1, b"77777777777\0"
    header[148:156] = b"%06o\0 " % (sum(header[:148]) + sum(header[156:512]) + 8 * 32)
    return bytes(header) + (b"00000000001\0" * 42 + b"\1" + bytes(7)) * 20_000


TARS = [
    archive("tar-that-claims-8-exabytes", "a.tar", tar_that_claims(HUGE, pax=False)),
    archive("tar-that-claims-8-exabytes-in-a-record", "a.tar", tar_that_claims(HUGE, pax=True)),
    archive("tar-that-claims-less-than-nothing", "a.tar", tar_that_claims(-(2**40), pax=True)),
    archive("tar-with-a-map-without-an-end", "a.tar", tar_with_a_sparse_map()),
    archive("gzip-of-a-gigabyte", "a.tar.gz", lambda: gzip.compress(bytes(1 << 20), 9) * 1000),
    archive("gzip-of-100000-members", "a.tar.gz", gzip.compress(b"") * 100_000),
]

# ---------------------------------------------------------------- notebooks


def book(**cell: object) -> str:
    return json.dumps({"cells": [{"cell_type": "code", "metadata": {}, "outputs": [], "source": "x = 1", **cell}], "metadata": {}, "nbformat": 4})


BOOKS = [
    beside("notebook-of-numbers-without-end", {"lab.ipynb": '{"cells": ' + "9" * 2_000_000 + "}"}),
    beside("notebook-whose-source-is-a-number", {"lab.ipynb": book(source=10**30)}),
    beside("notebook-whose-lines-are-lists", {"lab.ipynb": book(source=[["x"], {"y": 1}, None, 3])}),
    beside("notebook-of-a-line-of-magic", {"lab.ipynb": notebook("%" * 500_000, "!" * 500_000, "%%" + "x" * 500_000)}),
    beside("notebook-of-outputs-of-10-megabytes", {"lab.ipynb": book(outputs=[{"data": {"image/png": "A" * 10_000_000}}])}),
    beside("notebook-in-another-encoding", {"lab.ipynb": notebook("x = 1").encode("utf-16")}),
]

# ---------------------------------------------------------------- pictures


TEXT = (b"zTXt", b"Comment\0\0" + zlib.compress(bytes(20_000_000), 1))
PIXELS = (b"IDAT", zlib.compress(bytes(640 * 3 * 480 + 480)))


def picture(name: str, data: bytes | Callable[[], bytes]) -> Program:
    """A hand-in that draws nothing and hands this in; another picture of the same name would be read, too."""
    return Program(name, "bytes", Late({**BLANK, "imu_data.png": data}), only="visualization")


PICTURES = [
    picture("png-of-no-pixels", png(head(0, 0), PIXELS, END)),
    picture("png-of-one-row-of-40-million", png(head(40_000_000, 1, 0), (b"IDAT", zlib.compress(bytes(40_000_001), 1)), END)),
    picture("png-with-a-text-of-20-megabytes", png(head(640, 480), TEXT, PIXELS, END)),
    picture("png-with-100000-chunks", png(head(640, 480), *[(b"tEXt", b"a\0b")] * 100_000, PIXELS, END)),
    picture("png-with-a-chunk-of-4-gigabytes", png(head(640, 480)) + struct.pack(">I", 0xFFFFFFFF) + b"IDAT" + bytes(1000)),
    picture("png-that-is-a-gif-of-many-frames", b"GIF89a" + struct.pack("<HHBBB", 9000, 4000, 0xF7, 0, 0) + bytes(768) + (b"!\xf9\4\0\0\0\0\0," + struct.pack("<HHHHB", 0, 0, 9000, 4000, 0) + b"\x08\1\0\0") * 3000 + b";"),
    picture("png-that-is-an-eps", b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 99999 99999\n" + b"%" * 3_000_000),
    picture("png-of-a-gigapixel-in-the-second-picture", lambda: canned_picture() + picture_bomb()),
]

# ---------------------------------------------------------------- data


LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True))
DATA = [
    beside("csv-of-formulas", {"data.csv": "=HYPERLINK(1),@SUM(1),+1,-1\r\n" * 1000, "=1+1.csv": "x"}),
    beside("yaml-that-laughs-a-billion-times", {"data.yaml": LAUGHS, "rubric.yaml": LAUGHS, "environment.yml": LAUGHS}),
    beside("yaml-that-runs-code", {"rubric.yaml": "criteria: !!python/object/apply:os.system ['touch @FOLDER@/owned']\n", ".imugrade/last.json": "{"}),
    beside("xml-that-laughs-a-billion-times", {"humanoid-sensors.xml": '<!DOCTYPE l [<!ENTITY a "' + "x" * 1000 + '">' + "".join(f'<!ENTITY {b} "{f"&{a};" * 20}">' for a, b in zip("abcdefg", "bcdefgh", strict=True)) + "]><mujoco>&h;</mujoco>"}),
    beside("xml-that-includes-the-host", {"humanoid-sensors.xml": '<mujoco><include file="/etc/passwd"/><include file="@SECRET@"/><include file="humanoid-sensors.xml"/></mujoco>'}),
    beside("toml-and-ini-of-other-tools", {"pyproject.toml": "x = " + "[" * 100_000, "setup.cfg": "[metadata]\n" * 50_000, "tox.ini": "%(x)s" * 50_000}),
]
EVERYTHING_AT_ONCE = Program(
    "every-reader-at-once", "bytes",
    Late({**sound(), "a.zip": partial(bomb, 50), "b.tar": tar_that_claims(HUGE, pax=False), "lab.ipynb": "[" * 200_000, "c.gz": lambda: gzip.compress(bytes(1 << 24)), "x.png": picture_bomb, "y.csv": "1," * 1_000_000, "z.yaml": LAUGHS, "j.json": "[" * 1_000_000}),
    only="sensor_access", keeps=("sensor_access",),
)  # fmt: skip
BYTES = [*ZIPS, *TARS, *BOOKS, *PICTURES, *DATA, EVERYTHING_AT_ONCE]
