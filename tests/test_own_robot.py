"""The instructor's own robot: graded on like the lab's, hidden like the lab's, and refused by line where it cannot be graded."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pytest

from grader.course.record.class_settings import ClassSettings, causes
from grader.engine import recording, rubric
from grader.engine.grader import Marker
from grader.engine.results import Result
from grader.intake import read_submission
from grader.kit import give, wheel
from grader.labs.imu import bundles
from grader.labs.imu.hidden_coverage import blind_spot
from grader.labs.imu.lab import LAB
from grader.labs.imu.robot import Model
from grader.people.roster import NO_ROSTER
from reference.self_contained import self_contained
from tests.examples import files
from tests.rubrics import edited, line_of
from tests.sandboxes import Opened
from tests.single_faults import lost_by

PACKAGE = "dm_control>=1.0.20,<2"
"""Its wheel has robots that nobody here made. It is fetched from the package index and never kept in this repository."""
_FOLDERS = ("suite", "third_party/ant", "locomotion/soccer/assets/boxhead")


ROBOTS = {
    "humanoid": ("suite/humanoid.xml", "torso_accel", "torso_gyro"),
    "ant": ("third_party/ant/ant.xml", "torso_accel", "torso_gyro"),
    "dog": ("suite/dog.xml", "accelerometer", "gyro"),
    "boxhead": ("locomotion/soccer/assets/boxhead/boxhead.xml", "sensor_torso_accel", "sensor_torso_gyro"),
}
"""Models of the wheel: the file, and the names of its accelerometer and gyroscope."""
SECRET = "a secret of the tests of other robots"

ROBOT = """\
<mujoco model="rover">
  {head}
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="hull" pos="0 0 0.4">
      {joint}
      <geom type="ellipsoid" size="0.3 0.2 0.1" mass="3"/>
      <geom type="sphere" pos="0.2 0.1 0.1" size="0.05" mass="0.4"/>
      <site name="imu" pos="0.05 0.02 0.1" quat="0.8 0.1 0.5 0.3"/>
      <body name="arm" pos="0.1 0 0.1">
        {arm}
        <geom type="capsule" fromto="0 0 0 0.1 0.1 0.3" size="0.03" mass="0.5"/>
      </body>
    </body>
  </worldbody>
  <sensor>
    <clock name="now"/>
    <gyro name="rates" site="imu"/>
    <framequat name="pose" objtype="site" objname="imu"/>
    <accelerometer name="force" site="imu"/>
  </sensor>
</mujoco>
"""


def rover(
    folder: Path, *, head: str = "", joint: str = "<freejoint/>", arm: str = '<joint type="ball" stiffness="2"/>'
) -> Path:
    path = folder / "rover.xml"
    path.write_text(ROBOT.format(head=head, joint=joint, arm=arm), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def robots(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Model]:
    """The models of dm_control, kept with what pytest keeps from run to run.

    Without a package index the tests that ask for it fail: they are the proof that other robots can be graded.
    """
    cache = getattr(request.config, "cache", None)
    kept = Path(cache.mkdir("dm_control")) if cache else tmp_path_factory.mktemp("dm_control")
    if not (kept / "whole").exists():
        command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "download", "--quiet", "--no-deps"]
        done = subprocess.run([*command, "--dest", str(kept), PACKAGE], capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.fail(f"{PACKAGE} cannot be fetched: {done.stderr[-500:]}")
        fetched = max(kept.glob("dm_control-*.whl"))
        with zipfile.ZipFile(fetched) as archive:
            wanted = [n for n in archive.namelist() if n.startswith(tuple(f"dm_control/{f}/" for f in _FOLDERS))]
            archive.extractall(kept, [name for name in wanted if not name.endswith(".py")])
        fetched.unlink()
        (kept / "whole").touch()
    return {name: Model(kept / "dm_control" / path, *sensors) for name, (path, *sensors) in ROBOTS.items()}


def rubric_for(
    folder: Path, model: Path | str = "rover.xml", accelerometer: str = "force", gyroscope: str = "rates"
) -> Path:
    """A copy of the shipped rubric that names this robot."""
    text = edited("  # path: my-humanoid.xml", f"  path: {model}")
    text = edited("accelerometer: torso_accelerometer", f"accelerometer: {accelerometer}", text)
    path = folder / "rubric.yaml"
    path.write_text(edited("gyroscope: torso_gyroscope", f"gyroscope: {gyroscope}", text), encoding="utf-8")
    return path


def exchanged(
    folder: Path, accelerometer: str = "force", gyroscope: str = "rates", file: str = "humanoid-sensors.xml"
) -> Path:
    """The sheet's own code with the names of these sensors, and of this model's file."""
    folder.mkdir(parents=True, exist_ok=True)
    names = {"torso_accelerometer": accelerometer, "torso_gyroscope": gyroscope, "humanoid-sensors.xml": file}
    for path in files("s01-sheet-verbatim"):
        content = path.read_bytes()
        for old, new in names.items() if path.suffix == ".py" else ():
            content = content.replace(old.encode(), new.encode())
        (folder / path.name).write_bytes(content)
    return folder


def marked(opened: Opened, rubric_file: Path, submission: Path, cache: Path, seed: str | None = None) -> Result:
    chosen = rubric.load(LAB, rubric_file)
    with opened(bundles.obtain(LAB, seed, cache, chosen.settings["model"]), chosen) as marker:
        return marker.mark(read_submission(submission, LAB.files))


def refusal(rubric_file: Path, cache: Path) -> list[str]:
    with pytest.raises(rubric.RubricError) as refused:
        bundles.obtain(LAB, None, cache, rubric.load(LAB, rubric_file).settings["model"])
    return str(refused.value).replace(str(rubric_file), "rubric.yaml").splitlines()


# --- robots that nobody here made -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        pytest.param("humanoid", None, id="humanoid-public", marks=pytest.mark.weekly),
        pytest.param("ant", None, id="ant-public", marks=pytest.mark.weekly),
        pytest.param("dog", SECRET, id="dog-secret", marks=pytest.mark.weekly),
        pytest.param("boxhead", SECRET, id="boxhead-secret"),
    ],
)
def test_the_sheets_own_code_with_the_names_exchanged_gets_all_points(
    opened: Opened, name: str, seed: str | None, robots: dict[str, Model], cache: Path, tmp_path: Path
) -> None:
    model = robots[name]
    assert model.path is not None
    sensors = model.accelerometer, model.gyroscope
    # The sheet's path leads to the robot, and so does any that ends in the name of its file.
    path = {} if seed else {"file": model.path.name}
    submission = exchanged(tmp_path / "lab", *sensors, **path)
    result = marked(opened, rubric_for(tmp_path, model.path, *sensors), submission, cache, seed)
    assert (lost_by(result), result.score, result.status) == ({}, 100.0, "graded")


def test_under_a_secret_the_robot_moves_otherwise(cache: Path, tmp_path: Path) -> None:
    model = Model(rover(tmp_path), "force", "rates")
    public, hidden = (bundles.obtain(LAB, seed, cache, model)["push"] for seed in (None, SECRET))
    n = min(len(public["time"]), len(hidden["time"]))
    for key in ("acceleration", "angular_velocity"):
        apart = np.sqrt(np.mean((public[key][:n] - hidden[key][:n]) ** 2))
        assert apart > 0.05 * public[key].std(), key


def test_an_imu_that_no_push_moves_is_told_to_the_instructor(
    robots: dict[str, Model], cache: Path, tmp_path: Path
) -> None:
    assert blind_spot(bundles.obtain(LAB, None, cache, robots["ant"])) == (  # its torso hangs in the air, fixed
        "ant.xml: the push does not change what its IMU reads, so the grader can hardly "
        "distinguish a run without a push from a right one"
    )
    assert blind_spot(bundles.shipped()) == ""
    assert blind_spot(bundles.obtain(LAB, None, cache, Model(rover(tmp_path), "force", "rates"))) == ""


# --- it is this robot, and no other -----------------------------------------------------------------------------------


def test_a_copy_without_the_files_that_it_includes_is_the_robot(opened: Opened, cache: Path, tmp_path: Path) -> None:
    rover(tmp_path, head='<include file="more.xml"/>')
    (tmp_path / "more.xml").write_text('<mujoco><option timestep="0.004"/></mujoco>')
    submission = exchanged(tmp_path / "lab", file="rover.xml")
    rover(submission, head='<include file="more.xml"/>')
    assert lost_by(marked(opened, rubric_for(tmp_path), submission, cache)) == {}


def test_traces_of_another_robot_are_refused_with_the_line(tmp_path: Path) -> None:
    rover(tmp_path)
    file = rubric_for(tmp_path)
    with pytest.raises(rubric.RubricError) as refused:
        Marker(rubric.load(LAB, file), bundles.shipped())
    assert str(refused.value) == (
        f"{file}:{line_of(file.read_text(), 'path:')}: the traces are of humanoid-sensors.xml (torso_accelerometer, torso_gyroscope), "
        "not of rover.xml (force, rates); record them with this rubric"
    )


def test_another_file_that_the_model_includes_makes_other_traces(cache: Path, tmp_path: Path) -> None:
    rover(tmp_path, head='<include file="more.xml"/>')
    model = Model(tmp_path / "rover.xml", "force", "rates")
    seen = []
    for timestep in ("0.004", "0.005", "0.004"):
        (tmp_path / "more.xml").write_text(f'<mujoco><option timestep="{timestep}"/></mujoco>')
        seen.append(bundles.obtain(LAB, None, cache, model))
    assert seen[0].sha256 == seen[2].sha256 != seen[1].sha256
    settings = [ClassSettings.of(rubric.load(LAB), NO_ROSTER, "latest", each) for each in seen]
    assert causes(settings[0], settings[1]) == (
        "other scenarios (another secret or model, or another version of MuJoCo or imugrade)",
    )
    assert causes(settings[0], settings[2]) == ()


# --- what cannot be graded --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"joint": "", "arm": ""},
            "the model has no joint, so there is no velocity to push (data.qvel[0]); give its robot a freejoint",
        ),
        (
            {"head": '<include file="common/sky.xml"/>'},
            "the model includes 'common/sky.xml', which is not there; paths in it are relative to the model",
        ),
        (
            {"head": '<option timestep="0.2"/>', "arm": '<joint type="hinge" stiffness="90000"/>'},
            "the simulation of the model becomes unstable within 2 s of the push; try a smaller timestep",
        ),
        ({"head": "</mujoco><no>"}, "MuJoCo cannot load the model: "),
    ],
)
def test_a_model_that_cannot_be_graded_is_refused_with_the_line(
    change: dict[str, str], said: str, cache: Path, tmp_path: Path
) -> None:
    rover(tmp_path, **change)
    file = rubric_for(tmp_path)
    (told,) = refusal(file, cache)
    ours = told.partition("XML parse error")[0]  # what follows is MuJoCo's
    assert ours == f"rubric.yaml:{line_of(file.read_text(), 'path:')}: {said}"


def test_each_sensor_that_is_missing_or_of_another_type_is_refused_with_its_line(cache: Path, tmp_path: Path) -> None:
    rover(tmp_path)
    file = rubric_for(tmp_path, accelerometer="torso_accel", gyroscope="pose")
    first, second = (line_of(file.read_text(), f"{name}:") for name in ("accelerometer", "gyroscope"))
    assert refusal(file, cache) == [
        f"rubric.yaml:{first}: the model has no sensor 'torso_accel'; its accelerometers are force",
        f"rubric.yaml:{second}: the model's sensor 'pose' is of type framequat; its gyroscopes are rates",
    ]


# --- one text ---------------------------------------------------------------------------------------------------------

_CUBE = "".join(
    f"v {x} {y} {z}\n" for x in (0.0, 0.4) for y in (0.0, 0.2) for z in (0.0, 0.1)
) + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"  # fmt: skip
_MESHED = """\
<mujoco>
  <compiler meshdir="shapes"/>
  <asset><mesh name="brick" file="brick.obj" scale="1 1 2"/><texture name="t" type="2d" file="brick.png"/>
    <material name="m" texture="t"/></asset>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="brick" pos="0 0 0.3" euler="5 0 0">
      <freejoint/>
      <geom name="touching" type="mesh" mesh="brick" pos="0.01 0.02 0.03" euler="0 0 20" material="m"/>
      <geom name="shown" type="mesh" mesh="brick" pos="0.3 0 0" contype="0" conaffinity="0"/>
      <geom name="fitted" type="box" mesh="brick" pos="-0.4 0 0"/>
      <site name="imu"/>
    </body>
  </worldbody>
  <sensor><accelerometer name="force" site="imu"/><gyro name="rates" site="imu"/></sensor>
</mujoco>
"""


def test_a_mesh_becomes_what_it_weighs_and_what_it_touches_with(tmp_path: Path) -> None:
    (tmp_path / "shapes").mkdir()
    (tmp_path / "shapes" / "brick.obj").write_text(_CUBE)
    plt.imsave(tmp_path / "brick.png", np.zeros((8, 8)))
    (tmp_path / "brick.xml").write_text(_MESHED)
    text = self_contained(tmp_path / "brick.xml")
    assert "file=" not in text
    one, other = mujoco.MjModel.from_xml_path(str(tmp_path / "brick.xml")), mujoco.MjModel.from_xml_string(text)
    np.testing.assert_allclose(other.body_mass, one.body_mass, rtol=1e-6)
    np.testing.assert_allclose(other.body_inertia, one.body_inertia, rtol=1e-6)
    ends = []
    for model in (one, other):
        data = mujoco.MjData(model)
        for _ in range(1000):
            mujoco.mj_step(model, data)
        assert data.ncon > 0  # it lies on the floor
        ends.append(np.array(data.qpos))
    # The same contacts; what is left is rounding in the shapes' frames, seen through a thousand steps.
    np.testing.assert_allclose(ends[1], ends[0], atol=2e-3)


# --- kits -------------------------------------------------------------------------------------------------------------


def test_a_kit_carries_the_robot_and_checks_with_it_where_there_is_no_reference(tmp_path: Path) -> None:
    rover(tmp_path, head='<include file="more.xml"/>')
    (tmp_path / "more.xml").write_text('<mujoco><option timestep="0.004"/></mujoco>')
    give.student(LAB, tmp_path / "kit", rubric_for(tmp_path, "./rover.xml"))
    beside_the_sheets = f"{LAB.model.rpartition('/')[0]}/rover.xml"
    model = tmp_path / "kit" / beside_the_sheets
    assert mujoco.MjModel.from_xml_path(str(model)).opt.timestep == 0.004
    starter = (tmp_path / "kit" / "imu_reader.py").read_text(encoding="utf-8")
    assert f'MODEL = "{beside_the_sheets}"' in starter
    assert '"force")' in starter
    assert "torso" not in starter
    with zipfile.ZipFile(io.BytesIO((tmp_path / "kit" / wheel.name()).read_bytes())) as archive:
        archive.extractall(tmp_path / "installed")
    work = exchanged(tmp_path / "kit" / "work", file="rover.xml")
    program = [sys.executable, "-c", "from grader.cli import main; main()", "check", str(work), "--json", "result.json"]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "installed"), "PYTHONSAFEPATH": "1"}
    environment[recording.CACHE_VARIABLE] = str(tmp_path / "cache")  # an empty one
    done = subprocess.run(program, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert '"score": 100.0' in (tmp_path / "result.json").read_text(encoding="utf-8")
