"""`imugrade traces plot --mine`: a student's series over the truth."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from grader import cli
from grader.labs.imu import bundles, motions
from tests.corpus.pieces import tidy


def test_a_students_series_is_drawn_over_the_truth_by_code_that_runs_in_the_box(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "lab").mkdir()
    escape = f"open({str(tmp_path / 'escaped')!r}, 'w')\n"
    (tmp_path / "lab" / "imu_reader.py").write_text(tidy()["imu_reader.py"] + escape)
    drawn: list[Figure] = []
    monkeypatch.setattr(motions, "_saved", lambda figure, path: drawn.append(figure) or path)
    code = cli.main(["traces", "plot", "-o", str(tmp_path / "plots"), "--mine", str(tmp_path / "lab")])
    assert code == 0
    assert [Path(line).name for line in capsys.readouterr().out.splitlines()] == [
        "mine_push.png",
        "mine_push_dirty.png",
    ]
    push = drawn[0].axes[0]
    curves = {line.get_label(): line for line in push.get_lines()}
    assert set(curves) == {f"{axis}, {whose}" for axis in "XYZ" for whose in ("truth", "yours")}
    for axis in "XYZ":
        mine, true = (np.asarray(curves[f"{axis}, {whose}"].get_ydata()) for whose in ("yours", "truth"))
        assert len(true) - len(mine) == 2  # the truth goes on for a while, for who records a step more
        assert np.abs(mine - true[: len(mine)]).max() < 1e-6
    assert not (tmp_path / "escaped").exists()


def test_a_submission_that_records_nothing_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "imu_reader.py").write_text(
        "def simulate_and_collect(model, data, duration_seconds=5.0):\n    raise ValueError('no')\n"
    )
    assert cli.main(["traces", "plot", "-o", str(tmp_path / "plots"), "--mine", str(tmp_path)]) == 2
    assert capsys.readouterr().err.splitlines() == [
        "imugrade: push: ValueError: no",
        "imugrade: push_dirty: ValueError: no",
        f"imugrade: {tmp_path} has no recording; imugrade check says why",
    ]


@pytest.mark.parametrize(
    "rows", [np.full((3, 3), np.nan), np.full((3, 3), 1e300), np.zeros((0, 3)), np.ones((9000, 3))]
)
def test_whatever_was_recorded_can_be_drawn(tmp_path: Path, rows: np.ndarray) -> None:
    mine = SimpleNamespace(time=np.full(3, np.nan), acceleration=rows, angular_velocity=None)
    assert motions.plot(bundles.shipped(), tmp_path, {"push": mine})[0].is_file()
