"""Diagnosis of `simulate_and_collect`: where the rows of each recording come from, and the fault that explains what is wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from grader.base.errors import NoAnswer
from grader.engine.charging import Judge
from grader.engine.findings import Raised, Skipped, Unusable
from grader.engine.hypothesis import Reason
from grader.engine.traces import Traces
from grader.labs.imu.data_collection import measure as facts_of
from grader.labs.imu.data_collection.diagnosis import Explained
from grader.labs.imu.data_collection.measure import (
    FORM,
    LAST_SENSOR,
    LEARNT_IDS,
    OTHER_IMU,
    OWN_WORLD,
    TIME_ATOL,
    Run,
    all_alike,
    complete,
)
from grader.labs.imu.data_collection.row_origins import RowOrigin, explain, explain_altered
from grader.labs.imu.lab import LAB
from grader.labs.imu.parameters import CALL_REASONS, departures
from grader.labs.imu.returned import if_nothing
from grader.labs.imu.student import Student

NAMED, COUNT, TIME, TRUTH, RESET, PUSH = CHECKS = (
    "returns_named_arrays", "sample_count", "time_axis", "matches_truth", "starts_from_reset", "applies_push"
)  # fmt: skip
_FOLLOWING = "a recording of the simulation: these rows do not change when the robot's motion changes"
_BOTH = "accelerations and angular velocities; the returned value does not have both"
_ROWS = "a recording of the motion: there is no row, or only a few, and the duration has many time steps"
_STAMPS = "time stamps; the returned value has none"


def measured(student: Student, truth: Traces) -> Explained:
    """Return the facts about two recordings by `simulate_and_collect`, and which simulated run each recording's rows come from.

    The student's code makes further recordings only if these two leave the cause of a fault open.
    """
    push = facts_of.run(student, truth, "push")
    if push.series.error is not None:
        raised = Raised(push.series.error, "collecting data")
        return Explained(facts_of.facts_of(truth, push, None, stopped=dict.fromkeys(CHECKS, raised)))
    origin, push = origin_of(student, truth, push, "push")
    follows = True
    if complete(push.series) and (origin is None or all_alike(push.series)):
        known = origin is not None or push.claim is not None
        follows = known and facts_of.follows_simulation(student, truth, push)
    later_origin, later, stop = _explain_later_run(student, truth, push)
    stops: dict[str, Exception] = {}
    unknown = (
        later is not None
        and complete(later.series)
        and later_origin is None
        and not (origin or RowOrigin()).fits(later)
    )
    if unknown and not facts_of.follows_simulation(student, truth, push):  # such as a recording of the push alone
        stops[RESET] = Skipped(_FOLLOWING)
    found = Explained(facts_of.facts_of(truth, push, later, follows=follows), origin, later_origin)
    if found.another_push or found.other_velocities:
        velocities = facts_of.starting_velocities(student, truth, push)
        found = replace(found, facts=replace(found.facts, velocities=velocities))
    return replace(found, facts=replace(found.facts, stopped={**stops, **_stops(found, stop)}))


def origin_of(student: Student, truth: Traces, run: Run, name: str) -> tuple[RowOrigin | None, Run]:
    """Return which simulated run the rows of `run` (scenario `name`) come from, None if unknown; and `run` to go on with.

    The `run` that is returned also holds the simulations that were made to find out. The run of right code is tried first, and
    counts if it predicts the rows; then runs from the start that the worker reports or, if it reports none, from likely wrong ones.
    """
    if not complete(run.series):
        return None, run
    origin = explain(run)
    if origin is None and not run.series.first_step and not all_alike(run.series):
        assumed = ((explain(each), each) for each in facts_of.with_assumed_starts(student, truth, run, name))
        origin, run = next(((found, each) for found, each in assumed if found is not None), (None, run))
    elif origin is None or origin.exchanged:
        run = facts_of.with_claim(student, truth, run)
        origin = explain(run) or origin
    if (origin is None or origin.of_other_sensors) and run.claim is not None:
        run = facts_of.with_own_reader(student, truth, run)
        if (own := RowOrigin(OWN_WORLD)).fits(run):
            return own, run
    return origin or explain(run) or explain_altered(run), run


def _explain_later_run(
    student: Student, truth: Traces, push: Run
) -> tuple[RowOrigin | None, Run | None, Exception | None]:
    """Return the origin of the rows of the run that starts with data of an earlier run, this run, and the error if it failed.

    What is missing is None: the first two after an error, the error otherwise.
    """
    try:
        later = facts_of.run(student, truth, "push_dirty", push)
    except NoAnswer as nothing:
        return None, None, nothing
    if later.series.error is not None:
        return None, None, Raised(later.series.error, "collecting data with another time step, after an earlier run")
    return *origin_of(student, truth, later, "push_dirty"), None


def _stops(found: Explained, stop: Exception | None) -> Mapping[str, Exception]:
    """Return, by check, the exception because of which its property could not be measured and the check cannot judge."""
    series, later, stops = found.series, found.facts.later, dict[str, Exception]()
    if stop is not None:
        stops |= dict.fromkeys((COUNT, RESET), stop)
    if not complete(series):
        stops |= dict.fromkeys((TRUTH, RESET, PUSH), Skipped(_BOTH))
    elif found.is_no_recording:
        stops |= dict.fromkeys((COUNT, RESET, PUSH), Skipped(_ROWS))
    elif not found.facts.follows:
        stops |= dict.fromkeys((COUNT, RESET, PUSH), Skipped(_FOLLOWING))
    if series.time is None and not complete(series):
        stops[TIME] = Skipped(_STAMPS)
    elif stop is not None and series.time is not None and found.stamps_off <= TIME_ATOL:
        stops[TIME] = stop
    if later is not None and later.length and not complete(later.series):
        stops.setdefault(RESET, Skipped(_BOTH))
    if series.oddities and series.time is None and not any(rows is not None for rows in series.sensors):
        got = series.oddities[0][1].removeprefix("got ")
        stops[NAMED] = Unusable(FORM, got, faults=[series.oddities[0][0]], hint=if_nothing(got))
    return stops


# ---- the reasons


ROW_FAULTS: tuple[tuple[str, Callable[[Explained], bool]], ...] = (
    ("sensor-not-stored", lambda e: bool(e.series.absent) and not e.plain),
    ("not-finite", lambda e: not e.plain and not e.finite),
    ("ends-early", lambda e: e.ends_at_once or (e.push is None and e.is_right(0) and e.is_right(1))),
    ("nothing-simulated", lambda e: not e.series.first_step and (e.push is None or (e.plain and e.stands_still))),
    ("only-last-row", lambda e: e.last_alone and e.plain and e.facts.push.length == 1),
    ("read-before-step", lambda e: e.one_is_late),
    ("rows-altered", lambda e: e.treated),
    (f"data_collection.{TRUTH}", lambda e: not e.plain),
    ("other-imu", lambda e: _from(e).startswith(OTHER_IMU)),
    ("hard-coded-address", lambda e: _from(e) == LEARNT_IDS),
    ("sensor-not-found", lambda e: _from(e) == LAST_SENSOR),
    ("modifies-model", lambda e: bool(e.model_changed)),
    ("starts-over", lambda e: e.starts_over),
    (f"data_collection.{TRUTH}", lambda e: e.stands_still),
    ("only-last-row", lambda e: e.series.last_alone),
    ("aliased-rows", lambda e: e.push is not None and e.push.aliased),
    ("channels-swapped", lambda e: e.push is not None and e.push.exchanged),
    ("samples-skipped", lambda e: e.skips_steps),
    ("first-row-empty", lambda e: e.late > 0 and e.steps_beyond_rows == -1 and e.first_row_is_zero),
    ("read-before-step", lambda e: e.late > 0),
    ("first-steps-missing", lambda e: e.late < 0),
    ("rows-left-zero", lambda e: e.series.filled_rows < e.facts.push.length),
)
"""Faults of the rows and their tests. The first that holds counts: a fault stands after those that hide it."""


def _from(found: Explained) -> str:
    return found.push.world if found.push is not None else ""


def row_fault(found: Explained) -> str:
    """Return the id of the first fault in `ROW_FAULTS` that the first recording shows, such as "read-before-step"; "" for none."""
    return next((fault for fault, holds in ROW_FAULTS if holds(found)), "")


_FORMS = ("wrong-keys", "wrong-return-type", "arrays-transposed")
_COUNTS = ("ignores-duration", "hard-coded-timestep", "fixed-rate", "samples-skipped")
REASONS: tuple[Reason[Explained], ...] = (
    *(
        Reason(NAMED, 1, fault, lambda e, f=fault: f in dict(e.odd_form), beside=True)  # type: ignore[misc]
        for fault in _FORMS
    ),
    *(
        Reason(TRUTH, n, fault, lambda e, f=fault: row_fault(e) == f)  # type: ignore[misc]
        for n, fault in enumerate(dict(ROW_FAULTS))
    ),
    Reason(COUNT, 0, "ignores-duration", lambda e: e.second_is_empty and not e.few_rows_follow),
    *(
        Reason(COUNT, 1 + n, fault, lambda e, f=fault: e.counts_by(f))  # type: ignore[misc]
        for n, fault in enumerate(_COUNTS)
    ),
    Reason(RESET, 1, "modifies-model", lambda e: bool(e.model_left_changed)),
    Reason(RESET, 2, "keeps-old-rows", lambda e: e.rows_left > 0),
    Reason(RESET, 3, "no-reset", lambda e: e.goes_on),
    Reason(PUSH, 0, "starts-over", lambda e: e.starts_over),
    Reason(PUSH, 1, "random-push", lambda e: e.pushed_apart),
    Reason(PUSH, 2, "no-perturbation", lambda e: e.without_push),
    Reason(PUSH, 3, "driven-in-every-step", lambda e: e.driven),
    Reason(PUSH, 4, "wrong-perturbation", lambda _: True),
    Reason(TIME, 1, "not-finite", lambda e: not e.stamps_follow and not np.isfinite(e.stamps).all()),
    Reason(TIME, 2, "hard-coded-timestep", lambda e: not e.stamps_follow and e.keeps_timestep is not None),
    Reason(TIME, 3, "time-axis-wrong", lambda e: not e.stamps_follow),
    *CALL_REASONS,
)

JUDGE: Judge[Explained] = Judge(
    LAB, "data_collection", measured, REASONS, departures("simulate_and_collect", lambda found: found.series.departs)
)
