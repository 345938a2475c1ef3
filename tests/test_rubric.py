"""The rubric is read whole or refused with every problem, each with its line."""

from __future__ import annotations

import builtins
import pickle
import re
from collections.abc import Callable
from dataclasses import fields
from datetime import datetime, timezone
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grader.base.errors import RequestError
from grader.base.text import printable
from grader.engine import rubric, rubric_sections
from grader.engine.lab import Lab
from grader.engine.marks import marked
from grader.engine.results import Repair, Result, Unrepaired
from grader.engine.rubric import RubricError
from grader.labs.imu.lab import LAB
from grader.labs.imu.robot import Model
from tests.rubrics import SHIPPED, edited, line_of

OF_FILTERING = SHIPPED[SHIPPED.index("id: filtering") :].split("\n\n")[0]
CHECKS = OF_FILTERING[OF_FILTERING.index("    checks:") :]


def read(text: str) -> rubric.Rubric:
    return rubric.parse(LAB, text.encode())


def refusal(call: Callable[..., object], *arguments: object) -> str:
    with pytest.raises(RequestError) as told:
        call(*arguments)
    return str(told.value)


def problems(data: bytes | str) -> list[str]:
    return refusal(rubric.parse, LAB, data.encode() if isinstance(data, str) else data).splitlines()


def test_the_shipped_rubric_is_the_sheets() -> None:
    shipped = rubric.load(LAB)
    titles = ("Sensor access", "Data collection", "Visualization", "Noise model", "Filtering")
    assert [(c.title, c.points) for c in shipped.criteria] == [(title, 20.0) for title in titles]
    assert [(e.id, e.file, e.points) for e in shipped.extensions] == [
        ("complementary_filter", "complementary_filter.py", 0.0),
        ("allan_variance", "allan_variance.py", 0.0),
        ("multiple_imus", "multi_imu.py", 0.0),
        ("realtime_visualization", "live_plot.py", 0.0),
    ]
    assert shipped.late is None
    assert shipped.limits == rubric.Limits(call_cpu_s=10.0, submission_cpu_s=120.0)
    assert shipped.settings["model"] == Model(None, "torso_accelerometer", "torso_gyroscope")


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("# The rubric of Lab 04-01.", "# Our own rubric of Lab 04-01.", True),
        ("points: 20\n", "points: 20.0\n", True),
        ("      follows_address: 6", "\n      follows_address: 6", True),
        ("# late:\n#   due:", "late:\n  due:", True),
        ("points: 20\n", "points: 21\n", False),
        ("title: Sensor access", "title: Sensors", False),
        ("call_cpu_s: 10", "call_cpu_s: 9", False),
        ("accelerometer: torso_", "accelerometer: head_", False),
        ("# extra_credit:", "extra_credit:", False),
    ],
)
def test_the_hash_changes_with_what_a_mark_depends_on_and_with_nothing_else(old: str, new: str, same: bool) -> None:
    assert (read(edited(old, new)).sha256 == rubric.load(LAB).sha256) == same


DUE = "due: 2026-11-20T23:59+01:00"


def test_the_late_policy_in_the_shipped_files_comment_is_one_and_of_one_only_the_date_is_needed() -> None:
    comment = SHIPPED[SHIPPED.index("# late:\n") :].split("\n\n")[0]
    due, extended = (datetime(2026, 11, day, 22, 59, tzinfo=timezone.utc) for day in (20, 24))
    assert read(SHIPPED + re.sub("(?m)^# ", "", comment)).late == rubric.LatePolicy(
        due, 10.0, 10.0, 7.0, {"jane@example.edu": extended}, "Europe/Berlin"
    )
    assert read(SHIPPED + f"late:\n  {DUE}").late == rubric.LatePolicy(due, 0.0, 0.0, None, {})
    percentage = read(SHIPPED + f"late:\n  {DUE}\n  grace_minutes: 43200\n  per_day: 2.5%").late
    assert percentage == rubric.LatePolicy(due, 43_200.0, 2.5, None, {})


# ---- the price of faults ----


def test_faults_cost_what_the_rubric_says_in_whichever_order() -> None:
    one, other, dearer = (
        read(SHIPPED + f"faults: {{{prices}}}\n")
        for prices in ("no-bias: 1.5, bias-shared: 0", "bias-shared: 0, no-bias: 1.5", "no-bias: 2, bias-shared: 0")
    )
    assert one.faults == other.faults == {"no-bias": 1.5, "bias-shared": 0.0}
    assert one.sha256 == other.sha256
    assert len({one.sha256, dearer.sha256, rubric.load(LAB).sha256}) == 3
    assert one.asked_sha256 == rubric.load(LAB).asked_sha256


def test_a_fault_costs_its_points_in_each_criterion_before_a_repair_too() -> None:
    unrepaired = dict.fromkeys(
        ("filtering.follows_recursion", "filtering.passes_constant", "sensor_access.follows_address"),
        Unrepaired(0.0, ("does-not-import",)),
    )
    repairs = (Repair("filters.py", "", 0.0, "", "", "", score_before=0.0),)
    found = Result("x", "graded", (), repairs=repairs, unrepaired=unrepaired)
    by = read(SHIPPED + "faults: {does-not-import: 4}\n")
    most = {check.id: check.max_points for check in by.checks}
    assert marked(found, by).repairs[0].score_before == sum(most[id_] for id_ in unrepaired) - 2 * 4


# ---- what is asked for ----


def test_a_part_that_the_rubric_has_is_known_and_another_is_refused_with_the_nearest_name() -> None:
    shipped = rubric.load(LAB)
    for known in (None, "filtering", "allan_variance"):
        rubric.know_part(shipped, known)
    names = ", ".join(part.id for part in shipped.parts)
    for wrong, told in {
        "filt\x1berin": "filt\\x1berin: the rubric has no such criterion; did you mean filtering?",
        "zzz": f"zzz: the rubric has no such criterion; there are {names}",
    }.items():
        assert refusal(rubric.know_part, shipped, wrong) == f"--only {told}"


# ---- the instructor's own checks ----


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "od\x1bd" / "checks"
    made.mkdir(parents=True)
    return made


def test_the_own_checks_beside_a_rubric_are_its_python_files_in_their_order(folder: Path) -> None:
    (folder / "folder.py").mkdir()
    for name in ("b.py", "a.py", "notes.txt"):
        (folder / name).write_text(f"# {name}\n")
    assert rubric.own_checks(LAB, folder.parent) == (("a.py", b"# a.py\n"), ("b.py", b"# b.py\n"))
    assert rubric.parse(LAB, SHIPPED.encode(), folder=folder.parent).own_checks == rubric.own_checks(LAB, folder.parent)
    assert rubric.load(LAB).own_checks == ()


def test_marks_and_what_is_asked_depend_on_what_own_checks_say() -> None:
    def hashes(own: bytes, text: str = SHIPPED) -> tuple[str, str]:
        found = rubric.parse(LAB, text.encode(), own=(("check_a.py", own),))
        return found.sha256, found.asked_sha256

    without = rubric.load(LAB)
    one, other = hashes(b"# one"), hashes(b"# other")
    assert len({one[0], other[0], without.sha256}) == len({one[1], other[1], without.asked_sha256}) == 3
    dearer = hashes(b"# one", edited("points: 20\n", "points: 21\n"))
    assert (dearer[0] != one[0], dearer[1]) == (True, one[1])
    assert read(edited("call_cpu_s: 10", "call_cpu_s: 9")).asked_sha256 != without.asked_sha256


def test_the_rubric_and_the_own_checks_of_a_kit_lie_with_the_lab(tmp_path: Path) -> None:
    class Kit(Lab):
        folder = tmp_path  # type: ignore[assignment]

    kit = Kit(**{each.name: getattr(LAB, each.name) for each in fields(LAB)})
    assert rubric.shipped(kit) == rubric.shipped(LAB)
    (tmp_path / "rubric.yaml").write_text(SHIPPED)
    assert rubric.shipped(kit) == tmp_path / "rubric.yaml"
    for name in ("checks", "own_checks"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "check_a.py").write_text(f"# of {name}")
    assert rubric.own_checks(kit, tmp_path) == (("check_a.py", b"# of own_checks"),)
    assert rubric.own_checks(LAB, tmp_path) == (("check_a.py", b"# of checks"),)


def test_own_checks_of_more_than_a_megabyte_and_files_that_cannot_be_read_are_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuses(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    for name in "ab":
        (folder / f"{name}.py").write_bytes(b"#" * 500_000)
    assert len(rubric.own_checks(LAB, folder.parent)) == 2
    (folder / "c.py").write_bytes(b"#")
    place = printable(str(folder), 500)
    assert refusal(rubric.own_checks, LAB, folder.parent) == f"{place}: more than 1,000,000 bytes of checks"
    monkeypatch.setattr(Path, "read_bytes", refuses)
    assert refusal(rubric.own_checks, LAB, folder.parent) == f"{place}: cannot be read (Permission denied)"
    monkeypatch.setattr(builtins, "open", refuses)
    told = f"{place}/a.py: cannot be read (Permission denied); check its permissions"
    assert refusal(rubric.load, LAB, folder / "a.py") == told


# ---- the criteria and their checks ----


def test_what_is_left_over_goes_to_the_largest_remainder_and_of_equal_ones_to_the_first() -> None:
    assert rubric_sections.divided(10.0, [1, 1, 1]) == [3.34, 3.33, 3.33]
    assert rubric_sections.divided(5.0, [2.9, 1.3, 2.2]) == [2.27, 1.01, 1.72]


def test_a_refusal_goes_to_another_process() -> None:
    error = RubricError("rubric.yaml:1: wrong")
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_the_order_is_free_and_a_call_may_take_all_the_time() -> None:
    start, second = SHIPPED.index("  - id: sensor_access"), SHIPPED.index("  - id: data_collection")
    third = SHIPPED.index("  - id: visualization")
    swapped = SHIPPED[:start] + SHIPPED[second:third] + SHIPPED[start:second] + SHIPPED[third:]
    found = read(edited("submission_cpu_s: 120", "submission_cpu_s: 10", swapped))
    assert [c.id for c in found.criteria] == [part.id for part in LAB.parts]
    assert found.limits == rubric.Limits(10.0, 10.0)


@pytest.mark.parametrize("empty", ["checks:", "checks: []", ""])
def test_an_extension_may_have_no_checks(empty: str) -> None:
    text = re.sub(r"(file: live_plot\.py\n)    checks:\n(?:      .*\n)*", rf"\1    {empty}\n", SHIPPED)
    assert read(text).extensions[-1].checks == ()


IN_THE_PARTS = """\
criteria:
  - id: sensor_acess
    # unknown criterion 'sensor_acess' (did you mean sensor_access?); the ids are sensor_access, data_collection, visualization, noise_model, filtering
    # the criterion data_collection is missing; add it
    # the criterion noise_model is missing; add it
    titel: Sensor access  # unknown key 'titel' in this criterion (did you mean title?); correct or remove it
    points: 20.123  # the points of sensor_access must have at most two decimals, not '20.123'; round it
    checks:
      a: -1  # the weight of a must be a number from 0 to 1000, not '-1'; correct it
      b: .nan  # the weight of b must be a number from 0 to 1000, not '.nan'; correct it
      b: 3  # 'b' appears twice in the checks of sensor_access (first on line 10); remove one
      c: 1e9  # the weight of c must be a number from 0 to 1000, not '1e9'; correct it
      C-d: 2  # 'C-d' is not the name of a check; write only the part after `sensor_access.`
      sensor_access.x: "1"  # 'sensor_access.x' is not the name of a check; write only the part after `sensor_access.`
        # the weight of sensor_access.x must be a number from 0 to 1000, not '1'; correct it
  - id: filtering
    title: 3  # the title of filtering must be text, not '3'; write it in quotes
    points: 20
    checks: {x: 0, y: 0}  # the weights of filtering sum to 0; give at least one check a weight
  - id: filtering  # the criterion filtering appears twice (first on line 16); remove one
    title: Filtering
    points: 20
    checks: []
  - noise_model  # this criterion must be `key: value` lines with the keys id, title, points, checks
  - id: visualization  # this criterion has no key `title`; add it
    # this criterion has no key `points`; add it
    # this criterion has no key `checks`; add it
extensions:
  - id: allan_variance  # the extension complementary_filter is missing; add it
    # the extension realtime_visualization is missing; add it
    title: Allan variance
    file: ../allan.py  # the file of allan_variance must be the name of a .py file, not '../allan.py'; correct it
    points: many  # the points of allan_variance must be a number from 0 to 1000, not 'many'; correct it
  - id: multiple_imus  # multiple_imus has points but no checks to earn them; set its points to 0
    title: Multiple IMUs
    file: allan.txt  # the file of multiple_imus must be the name of a .py file, not 'allan.txt'; correct it
    points: 5
    checks: []
limits: {call_cpu_s: 10, submission_cpu_s: 5}  # submission_cpu_s is less than call_cpu_s; make it at least as large
modle:  # unknown key 'modle' in the rubric (did you mean model?); correct or remove it
"""
BELOW_THEM = """\
late:
  due: 2026-11-20T23:59  # due must be a date and time with its offset from UTC, like 2026-11-20T23:59+01:00, not '2026-11-20T23:59'
  per_day: 110%  # per_day must be a number of points or a percentage from 0 % to 100 %, not '110%'
  grace_minutes: -1  # grace_minutes must be a number from 0 to 100000, not '-1'; correct it
  cut_off_days: soon  # cut_off_days must be a number from 0 to 1000, not 'soon'; correct it
  tz: Europe/Berlon  # there is no time zone 'Europe/Berlon'; name one like Europe/Berlin
  due_dates: {jane: tomorrow}
    # the due date of jane must be a date and time with its offset from UTC, like 2026-11-20T23:59+01:00, not 'tomorrow'
faults:
  sensor-id-as-adress: 1
    # there is no fault 'sensor-id-as-adress' (did you mean sensor-id-as-address?); `imugrade explain` lists them
  reading-clipped: 1  # the fault 'reading-clipped' is no longer told apart: sensor_access.matches_truth deducts for it
  no-bias: much  # the deduction for no-bias must be a number from 0 to 1000, not 'much'; correct it
  bias-shared: 1.125  # the deduction for bias-shared must have at most two decimals, not '1.125'; round it
extra_credit: {cap: much, top: 1}  # unknown key 'top' in extra_credit; correct or remove it
  # extra_credit has no key `each`; add it
  # the cap of extra_credit must be a number from 0 to 1000, not 'much'; correct it
"""


@pytest.mark.parametrize(("before", "lines"), [("", IN_THE_PARTS), (SHIPPED, BELOW_THEM)])
def test_every_problem_is_told_at_once_with_its_line(before: str, lines: str) -> None:
    """Behind each line, or below it, stands what is told of it."""
    expected, at = [], 0
    for number, line in enumerate(lines.splitlines(), before.count("\n") + 1):
        value, _, problem = line.partition("# ")
        at = number if value.strip() else at
        expected += [f"rubric.yaml:{at}: {problem}"] if problem else []
    told = problems(before + lines)
    of_checks = [line for line in told if "there is no check" in line or "has no weight" in line]
    assert [line for line in told if line not in of_checks] == expected
    assert bool(of_checks) == (not before)  # both kinds in one round; the names are not those of the lab


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "1: the file is empty; start again from the shipped rubric.yaml"),
        (b"a: 1\nb: \xff", "2: this is not UTF-8; save the file as UTF-8"),
        (b"a: 1\nb: \x07", "2: the character U+0007 is not text; remove it"),
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


def test_more_problems_than_a_screen_holds_are_counted() -> None:
    told = problems("\n".join(f"key{n:03}: 1" for n in range(100)))
    assert len(told) == 51
    assert told[-1] == "rubric.yaml: and 53 more problems; correct these first"


def test_criteria_that_are_worth_nothing_are_refused() -> None:
    (told,) = problems(SHIPPED.replace("points: 20", "points: 0"))
    assert told.endswith(": the criteria are worth 0 points together; give at least one of them points")


ONE_LINE = ("# extra_credit: {each: 5, cap: 10}", "extra_credit: {each: 5, cap: 10}")
OF_ITS_OWN, OF_ANOTHER = (
    (f"    file: {name}.py\n", f"    file: {name}.py\n    points: {points}\n")
    for name, points in (("allan_variance", 0.2), ("complementary_filter", 0.1))
)


@pytest.mark.parametrize(
    ("edits", "points", "cap"),
    [
        ([ONE_LINE], [5.0] * 4, 10.0),
        ([OF_ITS_OWN, OF_ANOTHER], [0.1, 0.2, 0.0, 0.0], 0.3),
        ([ONE_LINE, OF_ITS_OWN], [5.0, 0.2, 5.0, 5.0], 10.0),
        ([(ONE_LINE[0], "extra_credit: {each: 5}")], [5.0] * 4, 20.0),
        ([(ONE_LINE[0], "extra_credit: {each: 0, cap: 10}")], [0.0] * 4, None),
        ([(ONE_LINE[0], "extra_credit: {each: 5, cap: 0}")], [5.0] * 4, 0.0),
    ],
)
def test_one_line_makes_the_extensions_extra_credit_and_leaves_the_score_alone(
    edits: list[tuple[str, str]], points: list[float], cap: float | None
) -> None:
    text = SHIPPED
    for old, new in edits:
        text = edited(old, new, text)
    granted = read(text + f"late:\n  {DUE}\n  per_day: 10%\n")
    assert [extension.points for extension in granted.extensions] == points
    assert all(sum(c.max_points for c in e.checks) == pytest.approx(e.points) for e in granted.extensions if e.checks)
    assert (granted.extra_credit_cap, sum(criterion.points for criterion in granted.criteria)) == (cap, 100.0)
    assert granted.late is not None
    assert granted.late.per_day == 10.0


def test_a_rubric_of_an_earlier_version_is_read_with_the_names_that_its_keys_had() -> None:
    earlier = f"late:\n  {DUE}\n  extensions: {{jane: 2026-11-24T23:59+01:00}}\nmistakes: {{no-bias: 1}}\n"
    now = earlier.replace("extensions", "due_dates").replace("mistakes", "faults")
    assert read(edited("", earlier)).sha256 == read(edited("", now)).sha256
    assert read(edited("", earlier)).late == read(edited("", now)).late


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("", "late:\n  grace_minutes: 5", "late has no key `due`; add it"),
        ("", f"late:\n  {DUE}\n  per_day: 7.125", "per_day must have at most two decimals, not '7.125'; round it"),
        ("", f"late:\n  {DUE}\n  due_dates: [jane]", "due_dates must be `who: date` lines; who is an id, a name or an e-mail"
         " address"),
        ("", "faults: [no-bias]", "faults must be `name: points` lines; `imugrade explain` lists the names"),
        ("", "repairs: {apply: always, deduct: 5}", "apply must be suggested or none, not 'always'"),
        ("", "repairs: {apply: suggested}", "repairs has no key `deduct`; add it"),
        ("call_cpu_s: 10", "call_cpu_s: 0.09", "call_cpu_s must be a number from 0.1 to 1000, not '0.09'; correct it"),
        ("submission_cpu_s: 120", "submission_cpu_s: 100001", "submission_cpu_s must be a number from 0.1 to 100000, not"
         " '100001'; correct it"),
        *(
            (CHECKS, f"    checks: {wrong}\n", "the checks of filtering must be `name: weight` lines; list at least one")
            for wrong in ("3", "[]")
        ),
        *(
            ("follows_address: 6 #", f"follows_address: {weight} #", "the weight of follows_address must be a number from 0 to 1000,"
             f" not '{weight}'; correct it")
            for weight in (".inf", "-0.1", "1000.1", "0x10", "1_0", "1:30", "", "yes")
        ),
    ],
)  # fmt: skip
def test_a_slip_is_told_with_its_line(old: str, new: str, told: str) -> None:
    text = edited(old, new) if old else SHIPPED + new
    line = line_of(text, new) + new.rstrip("\n").count("\n")
    assert problems(text) == [f"rubric.yaml:{line}: {told}"]


def test_a_model_is_looked_for_beside_the_rubric(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    text = edited("  # path: my-humanoid.xml", "  path: my-humanoid.xml")
    file.write_text(text, encoding="utf-8")
    line = line_of(text, "path: my-humanoid")
    told = f"{file}:{line}: there is no model 'my-humanoid.xml'; the path is relative to this file"
    assert refusal(rubric.load, LAB, file) == told
    (tmp_path / "my-humanoid.xml").write_text("<mujoco/>")
    assert rubric.load(LAB, file).settings["model"].path == tmp_path / "my-humanoid.xml"


def test_a_large_file_is_refused_as_it_lies_on_the_disk(tmp_path: Path) -> None:
    file = tmp_path / "rubric.yaml"
    file.write_bytes(SHIPPED.encode().ljust(1_000_000, b"#"))
    assert rubric.load(LAB, file).sha256 == rubric.load(LAB).sha256
    file.write_bytes(SHIPPED.encode().ljust(1_000_001, b"#"))
    with pytest.raises(RubricError, match=r"rubric\.yaml:1: the file is larger than 1 MB"):
        rubric.load(LAB, file)


def test_checks_and_rubric_must_match() -> None:
    shipped = rubric.load(LAB)
    known = {check.id: "a title" for check in shipped.checks}
    rubric.match_checks(shipped, known)
    del known["filtering.passes_constant"]
    known |= {"filtering.pass_constant": "Passes\x1b a constant", "magic.works": "Works"}
    assert refusal(rubric.match_checks, shipped, known).splitlines() == [
        "rubric.yaml:1: the check magic.works (Works) has no weight under magic; add the line `works: WEIGHT` to its"
        " checks",
        f"rubric.yaml:{line_of(SHIPPED, 'id: filtering')}: the check filtering.pass_constant (Passes\\x1b a constant) has"
        " no weight under filtering; add the line `pass_constant: WEIGHT` to its checks",
        f"rubric.yaml:{line_of(SHIPPED, 'passes_constant')}: there is no check filtering.passes_constant (did you mean"
        " filtering.pass_constant?); correct the name or remove the line",
    ]


@given(
    st.integers(0, 100_000).map(lambda hundredths: hundredths / 100),
    st.lists(st.integers(0, 100_000).map(lambda n: n / 100), min_size=1, max_size=12).filter(any),
)
def test_the_points_of_checks_sum_to_the_criterions(points: float, weights: list[float]) -> None:
    shares = rubric_sections.divided(points, weights)
    assert round(sum(shares), 2) == points
    for share, weight in zip(shares, weights, strict=True):
        assert abs(share - points * weight / sum(weights)) <= 0.010001
        assert round(share, 2) == share
