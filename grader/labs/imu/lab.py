"""Lab 04-01 as one `Lab` object, through which the grading engine reaches everything that belongs to this lab.

Every command reads this module first, so its functions import modules that need NumPy only when they are called.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from grader.engine.lab import Handout, Lab, LabFile, Part

if TYPE_CHECKING:
    from pathlib import Path

    from yaml import Node

    from grader.engine.chart_data import Chart
    from grader.engine.rubric_nodes import NodeReader
    from grader.engine.traces import Traces
    from grader.labs.imu.robot import Model
    from grader.labs.imu.student import Student
    from grader.sandbox.wire import Frame


def _student(*args: Any, **options: Any) -> Student:
    from grader.labs.imu.student import Student  # noqa: PLC0415

    return Student(*args, **options)


def _charts(student: Student, truth: Traces) -> tuple[Chart, ...]:
    from grader.labs.imu.charts import charts  # noqa: PLC0415

    return charts(student, truth)


def _checked(op: str, frame: Frame, fields: Mapping[str, Any], arrays: Mapping[str, Any]) -> Frame:
    from grader.engine.replies import checked  # noqa: PLC0415
    from grader.labs.imu.replies import RULES  # noqa: PLC0415

    return checked(op, frame, fields, arrays, RULES)


def _model(reader: NodeReader, node: Node | None, folder: Path) -> Model:
    from grader.labs.imu.robot import read_model  # noqa: PLC0415

    return read_model(reader, node, folder)


def _truth(seed: str | None, settings: Mapping[str, Any]) -> Traces:
    from grader.labs.imu.bundles import obtain  # noqa: PLC0415

    return obtain(LAB, seed, model=settings["model"])


def _blind_spot(truth: Traces) -> str:
    from grader.labs.imu.hidden_coverage import blind_spot  # noqa: PLC0415

    return blind_spot(truth)


def _match(settings: Mapping[str, Any], traces: Traces) -> None:
    from grader.labs.imu.robot import match_robot  # noqa: PLC0415

    match_robot(settings["model"], traces)


def _brought(settings: Mapping[str, Any]) -> LabFile | None:
    from grader.labs.imu.handout import brought  # noqa: PLC0415

    return brought(LAB, settings["model"])


def _handout(own: LabFile | None) -> Handout:
    from grader.labs.imu.handout import handout  # noqa: PLC0415

    return handout(LAB, own)


def _plot(truth: Traces, out: Path, own: Mapping[str, Any] | None) -> list[Path]:
    from grader.labs.imu.motions import plot  # noqa: PLC0415

    return plot(truth, out, own)


def _recordings(student: Student, truth: Traces, tell: Callable[[str], None]) -> Mapping[str, Any]:
    from grader.labs.imu.data_collection.measure import recordings  # noqa: PLC0415

    return recordings(student, truth, tell)


LAB = Lab(
    module=__name__,
    id="imu",
    label="Lab 04-01",
    title="Reading IMU data in MuJoCo",
    parts=(
        Part("sensor_access", "Sensor access", ("get_imu_readings",), "imu_reader.py"),
        Part("data_collection", "Data collection", ("simulate_and_collect",), "imu_reader.py"),
        Part(
            "visualization", "Visualization", ("plot_imu_data",), "imu_reader.py",
            needed=False, pictures=("imu_data.png", "filtered_imu.png"),
        ),
        Part("noise_model", "Noise model", ("NoisyIMU",), "noisy_imu.py"),
        Part("filtering", "Filtering", ("LowPassFilter",), "filters.py"),
    ),
    bonuses=(
        Part("complementary_filter", "Complementary filter", ("ComplementaryFilter",), "complementary_filter.py"),
        Part("allan_variance", "Allan variance", ("allan_deviation",), "allan_variance.py"),
        Part("multiple_imus", "Multiple IMUs", ("read_all_imus",), "multi_imu.py"),
        Part("realtime_visualization", "Real-time visualization", ("live_plot",), "live_plot.py"),
    ),
    student=_student,
    charts=_charts,
    checked=_checked,
    blind_spot=_blind_spot,
    truth=_truth,
    match=_match,
    brought=_brought,
    handout=_handout,
    plot=_plot,
    recordings=_recordings,
    repeating="grader.labs.imu.repeating",
    model="textbook/assets/robot-models/mujoco/humanoid-sensors.xml",
    points_to={"visualization.comparison_plot": "LowPassFilter"},
    calls={
        "get_imu_readings": "accel, gyro = get_imu_readings(model, data, accel_id, gyro_id)",
        "simulate_and_collect": "recording = simulate_and_collect(model, data, duration)",
        "plot_imu_data": "plot_imu_data(recording)",
        "NoisyIMU": "accel, gyro = NoisyIMU(model, data, accel_id, gyro_id, accel_noise_std, gyro_noise_std).read()",
        "LowPassFilter": "filtered = LowPassFilter(alpha).update(measurement)",
        "ComplementaryFilter": "roll, pitch = ComplementaryFilter(dt).update(accel, gyro)",
        "allan_deviation": "taus, adev = allan_deviation(samples, sample_rate)",
        "read_all_imus": "readings = read_all_imus(model, data)",
    },
    waits_for={
        "read": "get_imu_readings", "simulate": "simulate_and_collect", "noise": "NoisyIMU", "default_bias": "NoisyIMU",
        "filter": "LowPassFilter", "plot": "plot_imu_data",
    },
    settings={"model": _model},
    packages=("mujoco", "numpy", "scipy", "matplotlib"),
    suffixes=(*Lab.suffixes, ".xml"),
    libraries=(
        "scipy.integrate", "scipy.signal", "scipy.spatial.transform", "scipy.stats", "matplotlib.animation",
    ),
    recorder="reference.traces",
    depends_on=("mujoco", "numpy"),
    same_for_all=frozenset({"free_fall"}),
)  # fmt: skip
