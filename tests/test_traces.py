"""Trace bundles: recorded the same way twice, checked when they are read, obtained where they can be, and drawn."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from grader import cli
from grader.base.errors import GraderError, RequestError
from grader.engine import recording
from grader.engine import traces as truth
from grader.engine.lab import Lab
from grader.labs.imu import bundles, motions
from grader.labs.imu.lab import LAB
from reference import traces as recorder
from reference.scenarios import PUBLIC_SEED, drawn_settings, generator
from reference.variants import TIMESTEPS
from tests.corpus.pieces import tidy

SHIPPED = Path(bundles.__file__).with_name("public.npz")
SECRET = "correct horse ✓"

#: Between MuJoCo 3.0.0 and 4.0.0 the largest difference in the public bundle is 2e-8 of an array's largest number
#: (measured; summation order, amplified where feet strike the floor). Other processors round differently as well.
#: A hundred times that is allowed.
ROUND_OFF = 2e-6


@pytest.fixture(scope="module")
def public(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorder.record(tmp_path_factory.mktemp("public"))


@pytest.fixture(scope="module")
def hidden(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorder.record(tmp_path_factory.mktemp("hidden"), SECRET, "hidden")


def test_another_seed_gives_other_numbers_under_the_same_names(hidden: Path, tmp_path: Path) -> None:
    one, other = truth.load(hidden), truth.load(recorder.record(tmp_path, PUBLIC_SEED, "hidden"))
    assert one.arrays.keys() == other.arrays.keys()
    assert one.sha256 != other.sha256
    for key in ("tumbling/acceleration", "reading_lab/qpos", "noise/accel_bias", "filter/input"):
        assert np.abs(one.arrays[key] - other.arrays[key]).max() > 0.01, key
    assert all(one.models[name] != other.models[name] for name in ("lab", "shuffled", "many_imus"))
    shipped = bundles.shipped().arrays["noise/accel_bias"]  # of the same seed, which is no secret there
    assert np.abs(other.arrays["noise/accel_bias"] - shipped).max() > 0.01


def test_the_secret_is_nowhere_in_the_hidden_bundle(hidden: Path) -> None:
    manifest = hidden.with_suffix(".json").read_text(encoding="utf-8")
    assert "seed" not in json.loads(manifest)
    assert SECRET not in manifest
    assert json.dumps(SECRET)[1:-1] not in manifest
    assert SECRET.encode() not in hidden.read_bytes()


def test_the_shipped_bundle_is_what_the_reference_records_now(public: Path) -> None:
    ours, fresh = bundles.shipped(), truth.load(public)
    assert ours.arrays.keys() == fresh.arrays.keys()
    assert ours.manifest["scenarios"] == fresh.manifest["scenarios"]
    assert ours.models == fresh.models
    for key, array in fresh.arrays.items():
        if not key.endswith("sensor_type"):  # MuJoCo renumbers its sensor types between versions
            limit = ROUND_OFF * max(1.0, float(np.abs(array).max()))
            np.testing.assert_allclose(ours.arrays[key], array, rtol=0, atol=limit, err_msg=key)


# --- what the scenarios are good for --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["reading_lab", "reading_shuffled"])
def test_no_mistaken_address_reads_the_right_numbers_by_luck(public: Path, hidden: Path, name: str) -> None:
    """Each mistaken address is in range: it would be noticed by its length alone."""
    for bundle in (truth.load(public), truth.load(hidden)):
        s, lab = bundle[name], bundle["reading_lab"]
        for place, (accel, gyro) in enumerate(s.pairs):
            learnt = lab.sensor_adr[lab.pairs[place % 4]]
            for kind, sensor in enumerate((accel, gyro)):
                right = s.sensor_adr[sensor]
                wrong = {sensor, right - 1, right + 1, s.sensor_adr[(gyro, accel)[kind]]}
                wrong |= {learnt[kind]} if name == "reading_shuffled" else set()
                for address in wrong:
                    apart = [np.abs(row[address : address + 3] - row[right : right + 3]) for row in s.sensordata[:12]]
                    assert np.shape(apart) == (12, 3), (bundle.name, name, sensor, address)
                    assert np.max(apart) > 0.5, (bundle.name, name, sensor, address)


@pytest.mark.parametrize("usual", [factor * 0.002 for factor in TIMESTEPS])
@pytest.mark.parametrize("seed", range(20))
def test_drawn_settings_stay_within_what_the_sheet_would_ask(seed: int, usual: float) -> None:
    drawn = drawn_settings(generator("hidden", str(seed), "settings"), usual)
    assert 1.0 <= drawn.push_s <= 1.5
    assert 0.4 <= drawn.dirty_s <= 0.8
    for duration, timestep in ((drawn.push_s, usual), (drawn.dirty_s, drawn.dirty_timestep)):
        assert round(duration / timestep) * timestep == pytest.approx(duration, abs=1e-12)
    assert drawn.dirty_timestep != usual


# --- reading a bundle -----------------------------------------------------------------------------------------------


def test_scenarios_are_read_by_key_and_by_attribute_and_cannot_be_changed() -> None:
    push = bundles.shipped()["push"]
    assert push.acceleration is push["acceleration"]
    assert "acceleration" in push
    with pytest.raises(ValueError, match="read-only"):
        push.acceleration[0] = 0.0
    with pytest.raises(AttributeError, match="scenario 'push' has no array 'accelerations'"):
        _ = push.accelerations


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The shipped bundle, to be damaged."""
    for source in (SHIPPED, SHIPPED.with_suffix(".json")):
        shutil.copy(source, tmp_path)
    return tmp_path / SHIPPED.name


def refusal(path: Path) -> str:
    with pytest.raises(RequestError) as error:
        truth.load(path)
    return str(error.value)


def test_a_damaged_archive_or_a_changed_number_in_it_is_refused_in_one_line(copy: Path) -> None:
    with np.load(copy) as archive:
        arrays = {key: archive[key] for key in archive.files}
    arrays["push/acceleration"][3, 1] += 1e-12
    recorder.write_npz(copy, arrays)
    assert refusal(copy) == f"{copy}: the traces do not match their manifest; record them again"
    no_bundle = f"{copy}: not a trace bundle, or a damaged one; record the traces again"
    np.savez(copy, **{"push/time": np.array([{"a": 1}], dtype=object)})  # pickled objects are not loaded
    assert refusal(copy) == no_bundle
    for content in (b"PK\x03\x04 not an archive", b"\x80\x04pickled"):
        copy.write_bytes(content)
        assert refusal(copy) == no_bundle


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"push_mps": 0.5', '"push_mps": 0.6', "the traces do not match their manifest"),
        ("{", "", "the manifest is not JSON"),
        ('"imugrade/traces/', '"imugrade/traces/v0/', "its schema is 'imugrade/traces/v0/"),
    ],
)
def test_a_changed_manifest_is_refused_in_one_line(copy: Path, old: str, new: str, complaint: str) -> None:
    manifest = copy.with_suffix(".json")
    text = manifest.read_text(encoding="utf-8")
    assert old in text
    manifest.write_text(text.replace(old, new, 1), encoding="utf-8")
    assert complaint in refusal(copy)
    assert "\n" not in refusal(copy)


# --- obtaining one --------------------------------------------------------------------------------------------------


@pytest.fixture
def recordings(monkeypatch: pytest.MonkeyPatch, public: Path, hidden: Path) -> list[tuple[str, str]]:
    """Recorder runs, as (name, seed); instead of running, it copies what was recorded above."""
    calls: list[tuple[str, str]] = []

    def copied(lab: Lab, name: str, seed: str, out: Path, subject: recording.Subject | None) -> truth.Traces:
        assert (lab, subject) == (LAB, None)
        calls.append((name, seed))
        shutil.copytree({"public": public, "hidden": hidden}[name].parent, out)
        return truth.load(out / f"{name}.npz")

    monkeypatch.setattr(recording, "_record", copied)
    return calls


@pytest.fixture
def stretched_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "stretched", "{}, stretched".format)


@pytest.mark.usefixtures("stretched_at_once")
def test_a_hidden_bundle_is_recorded_once_for_its_owner_only_and_does_not_tell_its_seed(
    recordings: list[tuple[str, str]], tmp_path: Path
) -> None:
    first, again = (bundles.obtain(LAB, SECRET, tmp_path) for _ in range(2))
    assert recordings == [("hidden", recording.stretched(SECRET))]
    assert first.sha256 == again.sha256
    (entry,) = (tmp_path / "traces").iterdir()
    assert re.fullmatch("[0-9a-f]{32}", entry.name)
    assert entry.stat().st_mode & 0o077 == 0
    (entry / "hidden.npz").write_bytes(b"half of it")
    for _ in range(2):  # a damaged one is recorded again
        assert bundles.obtain(LAB, SECRET, tmp_path)["push"].scalars["push_mps"] == 0.5
    bundles.obtain(LAB, "another", tmp_path)
    assert recordings[1:] == [("hidden", recording.stretched(seed)) for seed in (SECRET, "another")]


def test_a_guess_at_a_secret_costs_scrypt_and_a_process_pays_once_for_a_secret(
    recordings: list[tuple[str, str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    costs: list[tuple[bytes, int]] = []

    def counted(secret: bytes, *, n: int, r: int, p: int, dklen: int, **_: object) -> bytes:
        costs.append((secret, n * r * p))
        return bytes(dklen)

    monkeypatch.setattr("hashlib.scrypt", counted)
    for _ in range(2):
        bundles.obtain(LAB, "one of its own", tmp_path)
    recording.stretched.cache_clear()  # of seeds that `counted` made
    assert costs == [(b"one of its own", 2**21)]
    assert not any("one of its own" in path.read_text("latin-1") for path in tmp_path.rglob("*.*"))


def test_public_traces_are_the_shipped_ones_on_the_simulator_that_recorded_them(
    recordings: list[tuple[str, str]], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    installed = bundles.shipped().versions["mujoco"]
    for module in (bundles, recording):
        monkeypatch.setattr(module, "version", lambda package: installed if package == "mujoco" else "1.0")
    assert bundles.obtain(LAB, None, tmp_path).sha256 == bundles.shipped().sha256
    assert recordings == []


def test_hidden_traces_without_the_reference_are_a_wrong_request(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(recording, "folder_of", lambda lab: None)
    with pytest.raises(RequestError, match="hidden traces need the reference, which is not installed here"):
        bundles.obtain(LAB, SECRET, tmp_path)


def reference_that(folder: Path, statement: str) -> Path:
    """A folder with a package `reference` whose recorder does only this."""
    (folder / "reference").mkdir()
    (folder / "reference" / "__init__.py").touch()
    (folder / "reference" / "traces.py").write_text(f"{statement}\n", encoding="utf-8")
    return folder


@pytest.mark.usefixtures("stretched_at_once")
def test_a_recorder_that_fails_is_the_graders_fault_and_says_why(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(recording, "_SOURCES", reference_that(tmp_path, "raise OSError('no space left')"))
    with pytest.raises(GraderError, match="recording the hidden traces failed: OSError: no space left"):
        bundles.obtain(LAB, SECRET, tmp_path / "cache")


@pytest.mark.usefixtures("stretched_at_once")
def test_a_recorder_that_does_not_end_is_given_up(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(recording, "RECORDING_LIMIT_S", 0.01)
    with pytest.raises(GraderError, match=r"^recording the hidden traces did not end within 0\.01 s$"):
        bundles.obtain(LAB, SECRET, tmp_path / "cache")


def test_the_same_seed_gives_the_same_bytes_also_beside_a_folder_called_reference_which_is_not_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, hidden: Path
) -> None:
    monkeypatch.chdir(reference_that(tmp_path, "raise SystemExit('a student was here')"))
    monkeypatch.setattr(recording, "stretched", lambda secret: secret)
    bundles.obtain(LAB, SECRET, tmp_path / "cache")
    for first in (hidden, hidden.with_suffix(".json")):
        (again,) = tmp_path.glob(f"cache/traces/*/{first.name}")
        assert again.read_bytes() == first.read_bytes()


# --- `imugrade traces plot --mine`: a student's series over the truth -----------------------------------------------------


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
