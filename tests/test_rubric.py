"""The rubric is read whole or refused with every problem, each with its line."""

from __future__ import annotations

import builtins
import pickle
import re
from dataclasses import fields
from datetime import datetime, timezone
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.engine import rubric
from grader.engine.lab import Lab
from grader.engine.rubric import RubricError
from grader.engine.rubric_nodes import Reader
from grader.labs.imu.lab import LAB
from grader.labs.imu.robot import Model

SHIPPED = rubric.shipped(LAB).read_bytes()


def problems(data: bytes | str) -> list[str]:
    with pytest.raises(RubricError) as refusal:
        rubric.parse(LAB, data.encode() if isinstance(data, str) else data)
    return str(refusal.value).splitlines()


def edited(old: str, new: str) -> str:
    text = SHIPPED.decode()
    assert old in text
    return text.replace(old, new, 1)


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


def test_the_shipped_rubric_is_the_sheets() -> None:
    shipped = rubric.load(LAB)
    assert [(c.title, c.points) for c in shipped.criteria] == [
        ("Sensor access", 20.0),
        ("Data collection", 20.0),
        ("Visualization", 20.0),
        ("Noise model", 20.0),
        ("Filtering", 20.0),
    ]
    assert shipped.max_score == 100.0
    assert [(e.id, e.file, e.points) for e in shipped.extensions] == [
        ("complementary_filter", "complementary_filter.py", 0.0),
        ("allan_variance", "allan_variance.py", 0.0),
        ("multiple_imus", "multi_imu.py", 0.0),
        ("realtime_visualization", "live_plot.py", 0.0),
    ]
    assert shipped.limits == rubric.Limits(call_cpu_s=10.0, submission_cpu_s=120.0)
    assert shipped.settings["model"] == Model(None, "torso_accelerometer", "torso_gyroscope")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("# The rubric of Lab 04-01.", "# Our own rubric of Lab 04-01."),
        ("points: 20\n", "points: 20.0\n"),
        ("      follows_address: 6", "\n      follows_address: 6"),
        ("# late:\n#   due:", "late:\n  due:"),
    ],
)
def test_what_no_mark_depends_on_leaves_the_hash_and_so_the_record_as_it_is(old: str, new: str) -> None:
    assert rubric.parse(LAB, edited(old, new).encode()).sha256 == rubric.load(LAB).sha256


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("points: 20\n", "points: 21\n"),
        ("follows_address: 6", "follows_address: 5"),
        ("title: Sensor access", "title: Sensors"),
        ("call_cpu_s: 10", "call_cpu_s: 9"),
        ("accelerometer: torso_", "accelerometer: head_"),
        ("# extra_credit:", "extra_credit:"),
    ],
)
def test_what_a_mark_depends_on_changes_the_hash(old: str, new: str) -> None:
    assert rubric.parse(LAB, edited(old, new).encode()).sha256 != rubric.load(LAB).sha256


def test_slips_of_every_kind_are_told_in_one_round() -> None:
    text = edited("follows_address: 6", "follows_adress: 6").replace("points: 20", "points: -1", 1)
    text = text.replace("time_axis: 3", "time_axis: many")
    told = problems(text + "mistakes: {no-such: 1}\n")
    assert [line.partition(": ")[2].partition(";")[0] for line in told] == [
        "the check sensor_access.follows_address (Reads the sensors that the ids name, at any address and "
        "in any model) has no weight under sensor_access",
        "the points of sensor_access must be a number from 0 to 1000, not '-1'",
        "there is no check sensor_access.follows_adress (did you mean sensor_access.follows_address?)",
        "the weight of time_axis must be a number from 0 to 1000, not 'many'",
        "there is no fault 'no-such'",
    ]


# ---- the late policy ----


def with_late(*lines: str) -> str:
    return SHIPPED.decode() + "late:\n" + "".join(f"  {line}\n" for line in lines)


DUE = "due: 2026-11-20T23:59+01:00"


def test_the_late_policy_in_the_shipped_files_comment_is_one() -> None:
    start = SHIPPED.decode().index("# late:\n")
    lines = SHIPPED.decode()[start:].split("\n\n")[0].splitlines()
    policy = rubric.parse(LAB, (SHIPPED.decode() + "\n".join(line.removeprefix("# ") for line in lines)).encode()).late
    assert policy == rubric.LatePolicy(
        datetime(2026, 11, 20, 22, 59, tzinfo=timezone.utc),
        10.0,
        10.0,
        7.0,
        {"jane@example.edu": datetime(2026, 11, 24, 22, 59, tzinfo=timezone.utc)},
        "Europe/Berlin",
    )


def test_without_a_late_policy_there_is_none_and_of_one_only_the_date_is_needed() -> None:
    assert rubric.load(LAB).late is None
    policy = rubric.parse(LAB, with_late(DUE).encode()).late
    assert policy is not None
    assert (policy.grace_minutes, policy.per_day, policy.cut_off_days, policy.extensions) == (0.0, 0.0, None, {})
    assert rubric.LatePolicy(policy.due, 0.0, 0.0, None) == policy
    assert rubric.parse(LAB, with_late(DUE, "per_day: 7.5").encode()).late.per_day == 7.5  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("lines", "problem"),
    [
        (["grace_minutes: 5"], "late has no key `due`; add it"),
        (
            ["due: 2026-11-20T23:59"],
            "due must be a date and time with its offset from UTC, like 2026-11-20T23:59+01:00, not '2026-11-20T23:59'",
        ),
        ([DUE, "per_day: 110%"], "per_day must be a number of points or a percentage from 0 % to 100 %, not '110%'"),
        ([DUE, "per_day: 7.125"], "per_day must have at most two decimals, not '7.125'; round it"),
        ([DUE, "grace_minutes: -1"], "grace_minutes must be a number from 0 to 100000, not '-1'; correct it"),
        ([DUE, "cut_off_days: soon"], "cut_off_days must be a number from 0 to 1000, not 'soon'; correct it"),
        (
            [DUE, "extensions: [jane]"],
            "extensions must be `who: date` lines; who is an id, a name or an e-mail address",
        ),
        (
            [DUE, "extensions: {jane: tomorrow}"],
            "the extension of jane must be a date and time with its offset from UTC, like 2026-11-20T23:59+01:00, not 'tomorrow'",
        ),
    ],
)
def test_a_slip_in_the_late_policy_is_told_with_its_line(lines: list[str], problem: str) -> None:
    (told,) = problems(with_late(*lines))
    assert re.fullmatch(r"rubric\.yaml:\d+: " + re.escape(problem), told)


def test_a_grace_may_last_for_weeks_and_a_day_may_cost_a_share_of_all_points() -> None:
    policy = rubric.parse(LAB, with_late(DUE, "grace_minutes: 43200", "per_day: 2.5%").encode()).late
    assert policy is not None
    assert (policy.grace_minutes, policy.per_day) == (43_200.0, 2.5)


def test_a_date_that_cannot_be_read_extends_nothing() -> None:
    reader = Reader("rubric.yaml")
    node = reader.compose(b"{due: 2026-11-20T23:59Z, extensions: {jane: soon, joe: 2026-11-21T23:59Z}}")
    policy = rubric._late(reader, node, 100.0)
    assert policy is not None
    assert list(policy.extensions) == ["joe"]


# ---- the price of mistakes ----


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (
            "mistakes: {sensor-id-as-adress: 1}",
            "there is no fault 'sensor-id-as-adress' (did you mean sensor-id-as-address?); `imugrade explain` lists them",
        ),
        (
            "mistakes: {reading-clipped: 1}",
            "the fault 'reading-clipped' is no longer told apart: sensor_access.matches_truth deducts for it",
        ),
        (
            "mistakes: {no-bias: much}",
            "the deduction for no-bias must be a number from 0 to 1000, not 'much'; correct it",
        ),
        (
            "mistakes: {no-bias: 1.125}",
            "the deduction for no-bias must have at most two decimals, not '1.125'; round it",
        ),
        ("mistakes: [no-bias]", "mistakes must be `name: points` lines; `imugrade explain` lists the names"),
        ("mistakes: {no-bias: 1, no-bias: 2}", "'no-bias' appears twice in mistakes (first on line LINE); remove one"),
    ],
)
def test_a_wrong_deduction_of_a_fault_is_reported_with_its_line(line: str, told: str) -> None:
    text = SHIPPED.decode() + line + "\n"
    at = str(line_of(text, line))
    assert problems(text) == [f"rubric.yaml:{at}: {told.replace('LINE', at)}"]


def test_mistakes_cost_what_the_rubric_says_in_whichever_order() -> None:
    one, other, dearer = (
        rubric.parse(LAB, SHIPPED + f"mistakes: {{{prices}}}\n".encode())
        for prices in ("no-bias: 1.5, bias-shared: 0", "bias-shared: 0, no-bias: 1.5", "no-bias: 2, bias-shared: 0")
    )
    assert one.mistakes == other.mistakes == {"no-bias": 1.5, "bias-shared": 0.0}
    assert one.sha256 == other.sha256
    assert len({one.sha256, dearer.sha256, rubric.load(LAB).sha256}) == 3
    assert one.asked_sha256 == rubric.load(LAB).asked_sha256


def test_points_of_several_parts_are_whole_hundredths_together() -> None:
    text = SHIPPED.decode()
    for points in ("0.1", "0.2", "0", "0", "0"):
        text = text.replace("points: 20\n", f"points: {points}\n", 1)
    assert rubric.parse(LAB, text.encode()).max_score == 0.3
    for name, points in (("complementary_filter", "0.1"), ("allan_variance", "0.2")):
        text = text.replace(f"    file: {name}.py\n", f"    file: {name}.py\n    points: {points}\n", 1)
    assert rubric.parse(LAB, text.encode()).extra_credit_cap == 0.3


@pytest.mark.parametrize("empty", ["checks: ~", "checks:", "checks: []", "checks: {}", ""])
def test_an_extension_may_have_no_checks(empty: str) -> None:
    text = re.sub(r"(file: live_plot\.py\n)    checks:\n(?:      .*\n)*", rf"\1    {empty}\n", SHIPPED.decode())
    assert rubric.parse(LAB, text.encode()).extensions[-1].checks == ()


# ---- what is asked for ----


def test_a_part_that_the_rubric_has_is_known_and_another_is_refused_with_the_nearest_name() -> None:
    shipped = rubric.load(LAB)
    for known in (None, "filtering", "allan_variance"):
        rubric.know_part(shipped, known)
    with pytest.raises(RequestError) as near:
        rubric.know_part(shipped, "filterin")
    assert str(near.value) == "--only filterin: the rubric has no such criterion; did you mean filtering?"
    with pytest.raises(RequestError) as far:
        rubric.know_part(shipped, "zzz")
    with pytest.raises(RequestError, match=r"^--only fil\\x1btering: "):
        rubric.know_part(shipped, "fil\x1btering")
    names = ", ".join(part.id for part in (*shipped.criteria, *shipped.extensions))
    assert str(far.value) == f"--only zzz: the rubric has no such criterion; there are {names}"


# ---- the instructor's own checks ----


def test_the_own_checks_beside_a_rubric_are_its_python_files_in_their_order(tmp_path: Path) -> None:
    folder = tmp_path / "checks"
    (folder / "folder.py").mkdir(parents=True)
    for name in ("b.py", "a.py", "notes.txt"):
        (folder / name).write_text(f"# {name}\n")
    assert rubric.own_checks(LAB, tmp_path) == (("a.py", b"# a.py\n"), ("b.py", b"# b.py\n"))
    assert rubric.parse(LAB, SHIPPED, folder=tmp_path).own_checks == rubric.own_checks(LAB, tmp_path)
    assert rubric.parse(LAB, SHIPPED).own_checks == ()


def test_marks_and_what_is_asked_depend_on_what_own_checks_say(tmp_path: Path) -> None:
    (tmp_path / "checks").mkdir()

    def hashes(content: str, data: bytes = SHIPPED) -> tuple[str, str]:
        (tmp_path / "checks" / "check_a.py").write_text(content)
        read = rubric.parse(LAB, data, folder=tmp_path)
        return read.sha256, read.asked_sha256

    without = rubric.load(LAB)
    one, other = hashes("# one"), hashes("# other")
    assert len({one[0], other[0], without.sha256}) == len({one[1], other[1], without.asked_sha256}) == 3
    assert all(re.fullmatch(r"[0-9a-f]{64}", digest) for digest in (*one, *other))
    dearer = hashes("# one", edited("points: 20\n", "points: 21\n").encode())
    assert (dearer[0] != one[0], dearer[1]) == (True, one[1])
    slower = rubric.parse(LAB, edited("call_cpu_s: 10", "call_cpu_s: 9").encode())
    assert slower.asked_sha256 != without.asked_sha256


def test_the_rubric_of_an_installation_lies_with_the_lab(tmp_path: Path) -> None:
    class Kit(Lab):
        folder = tmp_path  # type: ignore[assignment]

    kit = Kit(**{each.name: getattr(LAB, each.name) for each in fields(LAB)})
    assert rubric.shipped(kit) == rubric.shipped(LAB)
    (tmp_path / "rubric.yaml").write_bytes(SHIPPED)
    assert rubric.shipped(kit) == tmp_path / "rubric.yaml"


def test_a_kits_own_checks_lie_beside_the_labs(tmp_path: Path) -> None:
    class Kit(Lab):
        folder = tmp_path  # type: ignore[assignment]

    kit = Kit(**{each.name: getattr(LAB, each.name) for each in fields(LAB)})
    for name in ("checks", "own_checks"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "check_a.py").write_text(f"# of {name}")
    assert rubric.own_checks(kit, tmp_path) == (("check_a.py", b"# of own_checks"),)
    assert rubric.own_checks(LAB, tmp_path) == (("check_a.py", b"# of checks"),)


def test_own_checks_up_to_a_megabyte_together_are_read(tmp_path: Path) -> None:
    folder = tmp_path / "od\x1bd" / "checks"
    folder.mkdir(parents=True)
    for name in "ab":
        (folder / f"{name}.py").write_bytes(b"#" * 500_000)
    assert len(rubric.own_checks(LAB, folder.parent)) == 2
    (folder / "c.py").write_bytes(b"#")
    with pytest.raises(RubricError) as refusal:
        rubric.own_checks(LAB, folder.parent)
    assert str(refusal.value) == f"{tmp_path}/od\\x1bd/checks: more than 1,000,000 bytes of checks"


def _refuses(*_: object, **__: object) -> None:
    raise PermissionError(13, "Permission denied")


def test_files_that_cannot_be_read_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "od\x1bd" / "checks"
    folder.mkdir(parents=True)
    (folder / "a.py").touch()
    monkeypatch.setattr(Path, "read_bytes", _refuses)
    with pytest.raises(RubricError) as refusal:
        rubric.own_checks(LAB, folder.parent)
    assert str(refusal.value) == f"{printable(str(folder), 500)}: cannot be read (Permission denied)"
    monkeypatch.setattr(builtins, "open", _refuses)
    with pytest.raises(RubricError) as refusal:
        rubric.load(LAB, folder / "a.py")
    assert str(refusal.value) == (
        f"{printable(str(folder / 'a.py'), 500)}: cannot be read (Permission denied); check its permissions"
    )


# ---- the criteria and their checks ----


@pytest.mark.parametrize("key", ["title", "points", "checks"])
def test_every_key_of_a_criterion_is_needed(key: str) -> None:
    text = re.sub(rf"(id: filtering\n(?:.*\n)*?    ){key}:", r"\1# :", SHIPPED.decode(), count=1)
    if key == "checks":
        text = SHIPPED.decode()[: SHIPPED.decode().index("    checks:", SHIPPED.decode().index("id: filtering"))]
        text += SHIPPED.decode()[SHIPPED.decode().index("\nextensions:") :]
    line = line_of(text, "id: filtering")
    assert problems(text)[0] == f"rubric.yaml:{line}: this criterion has no key `{key}`; add it"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("file: allan_variance.py", "file: allan.txt", "the file of allan_variance must be the name of a .py file, not"
         " 'allan.txt'; correct it"),
        ("file: allan_variance.py", "file: ../allan.py", "the file of allan_variance must be the name of a .py file, not"
         " '../allan.py'; correct it"),
        ("file: allan_variance.py", "file: allan_variance.py\n    points: many", "the points of allan_variance must be a"
         " number from 0 to 1000, not 'many'; correct it"),
    ],
)  # fmt: skip
def test_a_slip_in_an_extension_is_told_with_its_line(old: str, new: str, told: str) -> None:
    text = edited(old, new)
    line = line_of(text, new) + new.count("\n")
    assert problems(text) == [f"rubric.yaml:{line}: {told}"]


def test_the_checks_of_a_part_must_be_lines_and_of_a_criterion_one_at_least() -> None:
    for wrong in ("3", "[]", "{}", "[returns_two_vectors]"):
        text = re.sub(
            r"(id: filtering\n(?:    .*\n)*?    checks:)\n(?:      .*\n)*", rf"\1 {wrong}\n", SHIPPED.decode()
        )
        told = f"rubric.yaml:{line_of(text, f'checks: {wrong}')}: the checks of filtering must be `name: weight` lines; list at least one"
        assert told in problems(text)


@pytest.mark.parametrize(
    ("points", "weights", "shares"),
    [
        (10.0, [1, 1, 1], [3.34, 3.33, 3.33]),
        (5.0, [2.9, 1.3, 2.2], [2.27, 1.01, 1.72]),
        (10.0, [2, 0, 2], [5.0, 0.0, 5.0]),
        (0.0, [1, 2], [0.0, 0.0]),
    ],
)
def test_what_is_left_over_goes_to_the_largest_remainder_and_of_equal_ones_to_the_first(
    points: float, weights: list[float], shares: list[float]
) -> None:
    assert rubric._shares(points, weights) == shares


def test_a_rubric_goes_to_another_process() -> None:
    shipped = rubric.load(LAB)
    assert pickle.loads(pickle.dumps(shipped)) == shipped
    refusal = RubricError("rubric.yaml:1: wrong")
    assert str(pickle.loads(pickle.dumps(refusal))) == str(refusal)
    assert isinstance(refusal, RequestError)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("call_cpu_s: 10", "call_cpu_s: 0.09", "call_cpu_s must be a number from 0.1 to 1000, not '0.09'; correct it"),
        (
            "submission_cpu_s: 120",
            "submission_cpu_s: 100001",
            "submission_cpu_s must be a number from 0.1 to 100000, not '100001'; correct it",
        ),
        (
            "submission_cpu_s: 120",
            "submission_cpu_s: 9.9",
            "submission_cpu_s is less than call_cpu_s; make it at least as large",
        ),
    ],
)
def test_a_slip_in_the_limits_is_told_with_its_line(old: str, new: str, told: str) -> None:
    text = edited(old, new)
    assert problems(text) == [f"rubric.yaml:{line_of(text, new)}: {told}"]


def test_a_call_may_take_all_the_time_and_extensions_may_earn_nothing() -> None:
    text = edited("submission_cpu_s: 120", "submission_cpu_s: 10").replace(
        ONE_LINE[0], "extra_credit: {each: 0, cap: 10}"
    )
    read = rubric.parse(LAB, text.encode())
    assert (read.limits, read.extra_credit_cap) == (rubric.Limits(10.0, 10.0), None)
    assert [extension.points for extension in read.extensions] == [0.0] * 4


def test_the_order_in_the_file_is_free() -> None:
    text = SHIPPED.decode()
    start, second = text.index("  - id: sensor_access"), text.index("  - id: data_collection")
    third = text.index("  - id: visualization")
    swapped = text[:start] + text[second:third] + text[start:second] + text[third:]
    assert [c.id for c in rubric.parse(LAB, swapped.encode()).criteria] == [part.id for part in LAB.parts]


def test_every_problem_is_told_at_once_with_its_line() -> None:
    told = problems(
        """\
criteria:
  - id: sensor_acess
    titel: Sensor access
    points: 20.123
    checks:
      a: -1
      b: .nan
      b: 3
      c: 1e9
      C-d: 2
      sensor_access.x: "1"
  - id: filtering
    title: 3
    points: 20
    checks: {x: 0, y: 0}
  - id: filtering
    title: Filtering
    points: 20
    checks: []
  - noise_model
extensions: 3
limits: {call_cpu_s: 10, submission_cpu_s: 5}
modle:
"""
    )
    of_checks = ("there is no check", "has no weight")  # both are told as well; the names are not those of the lab
    assert [line for line in told if not any(each in line for each in of_checks)] == [
        "rubric.yaml:2: unknown criterion 'sensor_acess' (did you mean sensor_access?);"
        " the ids are sensor_access, data_collection, visualization, noise_model, filtering",
        "rubric.yaml:2: the criterion data_collection is missing; add it",
        "rubric.yaml:2: the criterion visualization is missing; add it",
        "rubric.yaml:2: the criterion noise_model is missing; add it",
        "rubric.yaml:3: unknown key 'titel' in this criterion (did you mean title?); correct or remove it",
        "rubric.yaml:4: the points of sensor_access must have at most two decimals, not '20.123'; round it",
        "rubric.yaml:6: the weight of a must be a number from 0 to 1000, not '-1'; correct it",
        "rubric.yaml:7: the weight of b must be a number from 0 to 1000, not '.nan'; correct it",
        "rubric.yaml:8: 'b' appears twice in the checks of sensor_access (first on line 7); remove one",
        "rubric.yaml:9: the weight of c must be a number from 0 to 1000, not '1e9'; correct it",
        "rubric.yaml:10: 'C-d' is not the name of a check; write only the part after `sensor_access.`",
        "rubric.yaml:11: 'sensor_access.x' is not the name of a check; write only the part after `sensor_access.`",
        "rubric.yaml:11: the weight of sensor_access.x must be a number from 0 to 1000, not '1'; correct it",
        "rubric.yaml:13: the title of filtering must be text, not '3'; write it in quotes",
        "rubric.yaml:15: the weights of filtering sum to 0; give at least one check a weight",
        "rubric.yaml:16: the criterion filtering appears twice (first on line 12); remove one",
        "rubric.yaml:20: this criterion must be `key: value` lines with the keys id, title, points, checks",
        "rubric.yaml:21: this must be a list with one `- id: …` for each extension; see the shipped rubric.yaml",
        "rubric.yaml:22: submission_cpu_s is less than call_cpu_s; make it at least as large",
        "rubric.yaml:23: unknown key 'modle' in the rubric (did you mean model?); correct or remove it",
    ]


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "1: the file is empty; start again from the shipped rubric.yaml"),
        (b"a: 1\nb: \xff", "2: this is not UTF-8; save the file as UTF-8"),
        (b"a: 1\nb: \x07", "2: the character U+0007 is not text; remove it"),
        (b"x" * 1_000_001, "1: the file is larger than 1 MB; start again from the shipped rubric.yaml"),
        (b"[" * 100_000, "1: this is nested too deeply; see the shipped rubric.yaml for the layout"),
        (b"a: &x 1\nb: *x", "1: anchors and aliases (& and *) are not read; write the value out"),
        (b"- a\n" * 30_000, "19999: the file says far too much; start again from the shipped rubric.yaml"),
        (b'x: "\\UFFFFFFFF"', "1: the file is not YAML; start again from the shipped rubric.yaml"),
        (b"a: 1\nb: [", "2: YAML cannot be read here: while parsing a flow node, expected the node content, but found"
         " '<stream end>'; correct the line or the one before"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_tree_is_refused_in_one_line(data: bytes, problem: str) -> None:
    assert problems(data) == [f"rubric.yaml:{problem}"]


@pytest.mark.parametrize(
    "weight", ["inf", ".inf", "-0.1", "1000.1", "1e999", "0x10", "1_0", "1:30", "", "yes", "'6'", "[6]"]
)
def test_a_weight_is_a_plain_number(weight: str) -> None:
    text = edited("follows_address: 6 #", f"follows_address: {weight} #")
    shown = "a list or a mapping" if weight == "[6]" else f"'{weight.strip(chr(39))}'"
    assert problems(text) == [
        f"rubric.yaml:{line_of(text, 'follows_address')}: the weight of follows_address must be a number"
        f" from 0 to 1000, not {shown}; correct it"
    ]


def test_more_problems_than_a_screen_holds_are_counted() -> None:
    told = problems("\n".join(f"key{n:03}: 1" for n in range(100)))
    assert len(told) == 51
    assert told[-1] == "rubric.yaml: and 53 more problems; correct these first"


def test_criteria_that_are_worth_nothing_are_refused() -> None:
    told = problems(SHIPPED.decode().replace("points: 20", "points: 0"))
    assert [line.partition(": ")[2] for line in told] == [
        "the criteria are worth 0 points together; give at least one of them points"
    ]


ONE_LINE = ("# extra_credit: {each: 5, cap: 10}", "extra_credit: {each: 5, cap: 10}")


def test_one_line_makes_the_extensions_extra_credit_and_leaves_the_score_alone() -> None:
    plain, granted = rubric.load(LAB), rubric.parse(LAB, edited(*ONE_LINE).encode())
    assert [extension.points for extension in granted.extensions] == [5.0] * 4
    assert all(sum(c.max_points for c in e.checks) == pytest.approx(5.0) for e in granted.extensions if e.checks)
    assert (plain.extra_credit_cap, granted.extra_credit_cap) == (None, 10.0)
    assert plain.max_score == granted.max_score == 100.0
    assert all(check.max_points == 0.0 for extension in plain.extensions for check in extension.checks)


def test_an_extension_can_be_worth_points_of_its_own() -> None:
    text = edited("    file: allan_variance.py\n", "    file: allan_variance.py\n    points: 7\n")
    alone, beside = rubric.parse(LAB, text.encode()), rubric.parse(LAB, text.replace(*ONE_LINE).encode())
    assert [extension.points for extension in alone.extensions] == [0.0, 7.0, 0.0, 0.0]
    assert alone.extra_credit_cap == 7.0
    assert [extension.points for extension in beside.extensions] == [5.0, 7.0, 5.0, 5.0]
    assert beside.extra_credit_cap == 10.0


def test_extra_credit_without_a_cap_is_capped_by_what_there_is() -> None:
    assert rubric.parse(LAB, edited(ONE_LINE[0], "extra_credit: {each: 5}").encode()).extra_credit_cap == 20.0


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("extra_credit: {cap: 10}", "extra_credit has no key `each`; add it"),
        ("extra_credit: {each: 5, top: 1}", "unknown key 'top' in extra_credit; correct or remove it"),
        ("extra_credit: 5", "extra_credit must be `key: value` lines with the keys each, cap"),
        (
            "extra_credit: {each: 5, cap: much}",
            "the cap of extra_credit must be a number from 0 to 1000, not 'much'; correct it",
        ),
        ("extra_credit: {each: 5.125}", "each must have at most two decimals, not '5.125'; round it"),
    ],
)
def test_a_slip_in_extra_credit_is_told_with_its_line(line: str, told: str) -> None:
    text = edited(ONE_LINE[0], line)
    assert problems(text) == [f"rubric.yaml:{line_of(text, line)}: {told}"]


def test_extra_credit_without_a_check_is_refused() -> None:
    text = edited(
        "    file: allan_variance.py\n    checks:\n",
        "    file: allan_variance.py\n    points: 5\n    checks: []\n    was:\n",
    )
    line = line_of(text, "id: allan_variance")
    assert f"rubric.yaml:{line}: allan_variance has points but no checks to earn them; set its points to 0" in problems(
        text
    )


def test_a_model_is_looked_for_beside_the_rubric(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    text = edited("  # path: my-humanoid.xml", "  path: my-humanoid.xml")
    file.write_text(text, encoding="utf-8")
    with pytest.raises(RubricError) as refusal:
        rubric.load(LAB, file)
    line = line_of(text, "path: my-humanoid")
    assert str(refusal.value) == (
        f"{file}:{line}: there is no model 'my-humanoid.xml'; the path is relative to this file"
    )
    (tmp_path / "my-humanoid.xml").write_text("<mujoco/>")
    assert rubric.load(LAB, file).settings["model"].path == tmp_path / "my-humanoid.xml"


def test_a_path_without_a_file_is_one_line(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.yaml", Path("a\0b")):
        with pytest.raises(RubricError, match=r"there is no such file; give the path of a rubric\.yaml$"):
            rubric.load(LAB, path)


def test_a_large_file_is_refused_as_it_lies_on_the_disk(tmp_path: Path) -> None:
    file = tmp_path / "rubric.yaml"
    file.write_bytes(SHIPPED + b"#" * (1_000_000 - len(SHIPPED)))
    assert rubric.load(LAB, file).sha256 == rubric.load(LAB).sha256
    file.write_bytes(SHIPPED + b"#" * (1_000_001 - len(SHIPPED)))
    with pytest.raises(RubricError, match=r"rubric\.yaml:1: the file is larger than 1 MB"):
        rubric.load(LAB, file)


def test_checks_and_rubric_must_match() -> None:
    shipped = rubric.load(LAB)
    known = {check.id: "a title" for check in shipped.checks}
    rubric.match_checks(shipped, known)
    del known["filtering.passes_constant"]
    known |= {"filtering.pass_constant": "Passes\x1b a constant", "magic.works": "Works"}
    text = SHIPPED.decode()
    with pytest.raises(RubricError) as refusal:
        rubric.match_checks(shipped, known)
    assert str(refusal.value).splitlines() == [
        "rubric.yaml:1: the check magic.works (Works) has no weight under magic; add the line `works: WEIGHT` to its"
        " checks",
        f"rubric.yaml:{line_of(text, 'id: filtering')}: the check filtering.pass_constant (Passes\\x1b a constant) has"
        " no weight under filtering; add the line `pass_constant: WEIGHT` to its checks",
        f"rubric.yaml:{line_of(text, 'passes_constant')}: there is no check filtering.passes_constant (did you mean"
        " filtering.pass_constant?); correct the name or remove the line",
    ]


@given(
    st.integers(0, 100_000).map(lambda hundredths: hundredths / 100),
    st.lists(st.integers(0, 100_000).map(lambda n: n / 100), min_size=1, max_size=12).filter(any),
)
def test_the_points_of_checks_sum_to_the_criterions(points: float, weights: list[float]) -> None:
    shares = rubric._shares(points, weights)
    assert round(sum(shares), 2) == points
    for share, weight in zip(shares, weights, strict=True):
        assert abs(share - points * weight / sum(weights)) <= 0.010001
        assert round(share, 2) == share
