"""Whatever is handed in, the trusted side reads it in bounded time and memory. Each bound is far below what the bad case took."""

from __future__ import annotations

import gzip
import io
import tarfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from grader.base.errors import Malformed
from grader.engine import fingerprint
from grader.engine.figures import Axes, Curve
from grader.intake import read_submission
from grader.labs.imu.lab import LAB
from grader.labs.imu.visualization import comparing, labels
from grader.labs.imu.visualization.visibility import Patience, looked_at
from grader.sandbox.wire import Frame
from tests.budgets import cpu_within, memory_within
from tests.judging.test_check_visualization import SHEET, curve, figure_of
from tests.random_figures import figure_of as random_figure
from tests.random_figures import frame_of

# Archives -------------------------------------------------------------------------------------------------------------


def tar_that_claims(size: int, how: str) -> bytes:
    """A tar of three files, the last of which says that it is larger than any disk."""
    buffer = io.BytesIO()
    form = tarfile.PAX_FORMAT if how == "pax" else tarfile.GNU_FORMAT
    with tarfile.open(fileobj=buffer, mode="w", format=form) as archive:
        for name in ("filters.py", "imu_reader.py"):
            info = tarfile.TarInfo(name)
            info.size = 10
            archive.addfile(info, io.BytesIO(b"answer=42\n"))
        info = tarfile.TarInfo("noisy_imu.py")
        info.size = size if how == "header" else 0
        info.pax_headers = {"size": str(size)} if how == "pax" else {}
        buffer.write(info.tobuf(form))
    return buffer.getvalue()


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("how", ["header", "pax"])
@pytest.mark.parametrize("size", [2**63 - 1, 2**40, 10**9])
def test_a_tar_is_read_to_its_end_and_no_further_whatever_it_claims(
    tmp_path: Path, size: int, how: str, packed: bool
) -> None:
    """With 2**63 - 1 bytes it was read for ever: `tarfile` looks for the next file, a block at a time, behind the end."""
    data = tar_that_claims(size, how)
    path = tmp_path / "alice.tar"
    path.write_bytes(gzip.compress(data) if packed else data)
    with cpu_within(5):
        submission = read_submission(path, LAB.files)
    assert sorted(submission.files) == ["filters.py", "imu_reader.py"]
    assert submission.status != "unreadable"


# Fingerprints ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "source",
    ['"' + '\\"' * 190_000, '"""' + "\"'" * 190_000, 'f"{' * 130_000, "'\n\"" * 130_000],
    ids=range(4),
)
def test_a_fingerprint_takes_time_in_proportion_to_the_code(source: str) -> None:
    """A quotation mark and 200,000 escaped ones took half an hour: each one was the start of a string that never ends."""
    with cpu_within(10):
        fingerprint.fingerprint({"filters.py": source.encode()})


# Labels ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "word",
    ["metersec", "meterssec", "metrosporseg", "deg", "radian", "grad", "a", "°", "m/s", "\\frac{", "in ", "метр", "("],
)
def test_a_label_is_read_in_time_in_proportion_to_its_length(word: str) -> None:
    """A title of 8,000 letters of repeated units took a minute."""
    text = (word * 20_000)[:20_000]
    with cpu_within(3):
        for read in ("unit_of", "claims", "axis_of", "has_time_unit", "in_milliseconds", "counts_samples"):
            getattr(labels, read)(text)


# Replies --------------------------------------------------------------------------------------------------------------


def test_a_reply_that_names_one_array_many_times_is_no_answer() -> None:
    """0.3 MB that came over the line became 2.6 GB."""
    leaf = {"kind": "array", "key": "a0"}
    nested = {"kind": "list", "items": [{"kind": "list", "items": [leaf] * 64}] * 64}
    frame = Frame({"error": None, "value": nested, "changed": [], "departs": []}, {"a0": np.zeros(40_000)})
    with memory_within(20), cpu_within(5), pytest.raises(Malformed, match="array 'a0' in two places"):
        LAB.checked("simulate", frame, {}, {})


def test_a_reply_with_one_array_as_every_curve_is_no_answer() -> None:
    """One pair of such curves was compared for nine seconds, and there were 14,400 pairs."""
    with random_figure(0) as figure:
        frame = frame_of(figure)
    for axes in frame.fields["figures"][0]["axes"]:
        for each in axes["curves"]:
            each["x"] = each["y"] = "a0"
    arrays = {"a0": np.zeros(40_000), "seen": frame.arrays["seen"]}
    frame.fields.update(departs=[], given=None)
    with pytest.raises(Malformed, match="array 'a0' in two places"):
        LAB.checked("plot", Frame({**frame.fields, "error": None}, arrays), {}, {})


def panel(ylabel: str, *curves: Curve) -> Axes:
    """A panel as large as the picture."""
    ends = (0.0, 1.0)
    return replace(
        SHEET.axes[0], position=(0.0, 0.0, 1.0, 1.0), x_limits=ends, y_limits=ends, ylabel=ylabel, curves=curves
    )


def test_many_long_curves_are_compared_in_time() -> None:
    """As many numbers as a reply may hold, as 240 curves of one figure: comparing all pairs took a quarter of an hour."""
    rng = np.random.default_rng(0)
    rows = 4_000_000 // 480
    widths = [3, 40] * 120  # half of them smoother than the others, and none a version of one
    columns = [np.convolve(rng.normal(size=rows + k - 1), np.ones(k) / k, "valid") for k in widths]
    curves = [curve(np.arange(rows) * 1.0, y, "metersec" * 25, "#1f77b4") for y in columns]
    with cpu_within(40):
        assert comparing.comparisons(figure_of(panel("metersec" * 25, *curves))) == []


def test_filtered_curves_are_found_among_five_versions_of_each_channel() -> None:
    rng = np.random.default_rng(0)
    raw = rng.normal(size=(500, 6))
    versions = [raw, *(np.apply_along_axis(np.convolve, 0, raw, np.ones(k) / k, "same") for k in (3, 5, 7, 9, 11))]
    curves = [curve(np.arange(500.0), column, "", "#1f77b4") for column in np.hstack(versions).T]
    accel, gyro = ([each for n, each in enumerate(curves) if n % 6 // 3 == sensor] for sensor in (0, 1))
    assert (
        len(comparing.comparisons(figure_of(panel("m/s²", *accel), panel("rad/s", *gyro)))) > 42
    )  # as one sensor alone has


def test_a_reply_of_many_curves_in_many_colours_is_looked_at_in_time() -> None:
    """Two hundred and forty curves of sixteen colours each, in panels as large as the picture."""
    rng = np.random.default_rng(0)
    one = curve(rng.uniform(0, 1, 6000), rng.uniform(0, 1, 6000), "", "#1f77b4")
    curves = [
        replace(one, marker="o", width=9.0, inks=tuple(f"#{n:02x}{k:02x}80" for k in range(0, 256, 16)))
        for n in range(240)
    ]
    figure = figure_of(*(panel("", *curves[10 * n : 10 * n + 10]) for n in range(24)))
    pixels = rng.integers(0, 255, (640, 640, 3)).astype(np.uint8)
    with cpu_within(10):
        looked_at(replace(figure, pixels=pixels, extent=(640.0, 640.0), dots=50.0), Patience())
