"""Properties of a student's `simulate_and_collect` that checks and fault hypotheses ask about: form, rows, time stamps, start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from grader.labs.imu.collection import KEYS, SENSORS, Collection
from grader.labs.imu.compare import BOTH, SHEETS_NOISE, Array, deviation, vector
from grader.labs.imu.data_collection.measure import (
    ATOL_ACCELERATION,
    ATOL_RATE,
    CLAIMED_WORLD,
    FEWEST_ROWS,
    TIME_ATOL,
    TRUE_WORLD,
    Claim,
    Facts,
    Run,
    all_alike,
    complete,
    differ,
    velocities_in_words,
)
from grader.labs.imu.data_collection.row_origins import RowOrigin, moves, time_error, treatment


@dataclass(frozen=True)
class Explained:
    """Facts about a student's `simulate_and_collect`, and what explains its two recordings, for checks and hypotheses.

    `push` says which simulated run the rows of the first recording, made with the lab sheet's push, come from; `later` says it of
    the second recording, which begins with simulator data that is not reset. Each is None if unknown. Properties that name no
    recording are about the first one.
    """

    facts: Facts
    push: RowOrigin | None = None
    later: RowOrigin | None = None

    @property
    def stopped(self) -> Mapping[str, Exception]:
        return self.facts.stopped

    @property
    def series(self) -> Collection:
        """The recording of the run with the lab sheet's push, from which most properties follow."""
        return self.facts.push.series

    # ---- form

    @property
    def odd_form(self) -> list[tuple[str, str]]:
        """Deviations of names, shapes and lengths from the lab sheet: pairs of a fault's id ("" if it has none) and a sentence."""
        if self.series.oddities:
            return [(fault, sentence.removeprefix("got ")) for fault, sentence in self.series.oddities[:3]]
        arrays = dict(zip(KEYS, (self.series.time, *self.series.sensors), strict=True))
        sizes = {key: len(each) for key, each in arrays.items() if each is not None and key != self.series.absent}
        if not sizes:
            return [("", "all keys, but empty arrays")]
        if len(sizes) < len(KEYS):
            return [("wrong-return-type", f"no numbers under {', '.join(sorted(set(KEYS) - set(sizes)))}")]
        if len(set(sizes.values())) > 1:
            return [("wrong-return-type", ", ".join(f"{key} has {n} rows" for key, n in sizes.items()))]
        return []

    # ---- number of rows

    @property
    def count_off(self) -> Run | None:
        """The run with more or fewer rows than steps, the later one if both have; None if the check `sample_count` passes.

        One row more or less is accepted, as are zero rows after the last step, and too few rows that a missing reset explains.
        """
        if all(complete(run.series) and abs(run.series.filled_rows - run.steps) <= 1 for run in self.facts.runs):
            return None
        off = [run for run in self.facts.runs if abs(run.length - run.steps) > 1]
        missing = off[-1].steps - off[-1].length if off else 0
        if len(off) == 1 and off[0] is self.facts.later and self.goes_on:
            # a loop until data.time is the duration makes fewer steps where nothing was reset
            return None if abs(missing - self.facts.left_at / off[0].timestep) <= 1 else off[0]
        return off[-1] if off else None

    @property
    def ends_at_once(self) -> bool:
        """Return whether the recording stops after the first few rows, too few to identify a run: the fault `ends-early`."""
        few = self.series.filled_rows < min(FEWEST_ROWS, self.facts.push.model_steps // 2)
        return self.push is not None and self.push.skip == 1 and few

    @property
    def is_no_recording(self) -> bool:
        """Return whether so few different rows exist that they show no motion, so that no check of a run can be judged."""
        steps = self.series.first_step.get("steps", np.zeros(1))[0]
        few = min(FEWEST_ROWS, self.facts.push.model_steps // 2)
        rows = next(rows for rows in self.series.sensors if rows is not None)
        thinned = self.push is not None and self.push.skip > 1 and len(rows) > 1
        repeats = steps < few and len(np.unique(rows, axis=0)) < few
        return repeats or (self.series.filled_rows < few and not thinned)

    @property
    def last_alone(self) -> bool:
        """Return whether only one row is filled, with the reading after the last step: the fault `only-last-row`."""
        single = self.push is not None and self.push.skip > 1 and self.facts.push.length == 1
        return single or self.series.last_alone

    @property
    def few_rows_follow(self) -> bool:
        """Return whether rows are missing because of a fault that the check `matches_truth` deducts, so that they cost no more."""
        return self.ends_at_once or self.last_alone

    def counts_by(self, fault: str) -> bool:
        """Return whether both recordings' row counts show this fault, an id from `counting_fault`; False if the second failed."""
        first, second = self.facts.push, self.facts.later
        if second is None or not (first.length or second.length) or self.few_rows_follow:
            return False
        found = counting_fault(first, second, skips=self.push is not None and self.push.skip > 1)
        every_step = abs(first.length * self.facts.learnt_timestep - first.duration_s) <= self.facts.learnt_timestep
        return fault == ("hard-coded-timestep" if found == "fixed-rate" and every_step else found)

    # ---- time stamps

    @property
    def stamps(self) -> Array:
        """Time stamps (n,), in seconds, of the rows that the code filled, which the check `time_axis` judges."""
        assert self.series.time is not None
        return self.series.time[: (self.series.filled_rows if complete(self.series) else 0) or None]

    @property
    def stamp_errors(self) -> Array:
        """Distance (n,) of each time stamp from the true time, in seconds, for the check `time_axis`."""
        return time_error(self.stamps, self.facts.push.timestep, self.push or RowOrigin())

    @property
    def stamps_off(self) -> float:
        """Largest distance (s) of a time stamp from the true time, which the check `time_axis` limits."""
        return float(np.max(self.stamp_errors))

    @property
    def keeps_timestep(self) -> Run | None:
        """The run whose time stamps are spaced by a time step that is not its own, as if hard-coded; None if there is none.

        The first run counts if its stamps have the time step of the model that students have. The later run is looked at only if
        the first run's stamps are right, and counts if its own have the first run's time step.
        """
        push, later = self.facts.push, self.facts.later
        if self.stamps_off > TIME_ATOL:
            return push if has_timestep(self.stamps, push.model_timestep, self.facts.learnt_timestep) else None
        if later is None or later.series.time is None:
            return None
        time = later.series.time[: later.model_steps - 1]
        return later if has_timestep(time, later.timestep, push.model_timestep) else None

    @property
    def stamps_follow(self) -> bool:
        """Return whether another fault explains that time stamps are wrong or missing, so that no fault of the stamps is named.

        Such faults: the stamps are not as many as the rows, only the last row is filled, or the state is set in each step.
        """
        if self.series.time is None:
            return True
        lengths = {len(rows) for rows in self.series.sensors if rows is not None}
        if (lengths and len(self.series.time) not in lengths) or (
            self.series.last_alone and not self.series.time[:-1].any()
        ):
            return True
        claim = self.facts.push.claim
        return len(self.stamps) > 1 and not np.ptp(self.stamps) and claim is not None and len(claim.set_at) > 0

    # ---- rows

    @property
    def plain(self) -> bool:
        """Return whether all numbers come unaltered from a simulated run; rows may be late or missing, and sensors swapped."""
        return self.push is not None and not self.push.altered

    @property
    def stands_still(self) -> bool:
        return all_alike(self.series) and not self.facts.follows

    @property
    def starts_over(self) -> bool:
        """Return whether all rows after the first show one state: the code sets the start again in every pass of its loop."""
        again = self.push_claim is not None and len(self.push_claim.set_at) > 0
        filled = self.series.rows(1, self.series.filled_rows)
        return again and all_alike(filled) and self.push is not None and not self.push.aliased

    @property
    def driven(self) -> bool:
        """Return whether the code sets positions or velocities before most of its steps: the fault `driven-in-every-step`."""
        steps = self.series.first_step.get("steps", np.zeros(1))[0]
        return self.push_claim is not None and len(self.push_claim.set_at) > max(steps // 2, 1)

    @property
    def true_rows(self) -> tuple[Array, Array]:
        """Acceleration and angular velocity, each (rows, 3), that right code records from the start of the student's run.

        The worker reports that start, so that a wrong one makes no rows wrong. The scenario's start is taken if the rows come from
        it, if no reported start was simulated, or if the code sets the start again in every pass of its loop.
        """
        worlds = self.facts.push.worlds
        from_truth = self.starts_over or (self.push is not None and self.push.world == TRUE_WORLD)
        return worlds[TRUE_WORLD] if from_truth else worlds.get(CLAIMED_WORLD, worlds[TRUE_WORLD])

    def is_right(self, which: int) -> bool:
        """Return whether a sensor (0 accelerometer, 1 gyroscope) has right code's rows; False if right code's are constant."""
        got, true, atol = self.series.sensors[which], self.true_rows[which], (ATOL_ACCELERATION, ATOL_RATE)[which]
        return got is not None and deviation(got, true).worst <= atol and moves(true, atol, slice(len(got)))

    @property
    def one_is_late(self) -> bool:
        """Return whether one sensor has its true rows, and the other is read before the step: it has those of one step earlier."""
        return not self.plain and any(self.is_right(which) and self._is_late(1 - which) for which in BOTH)

    def _is_late(self, which: int) -> bool:
        rows, true, atol = self.series.sensors[which], self.true_rows[which], (ATOL_ACCELERATION, ATOL_RATE)[which]
        return rows is not None and len(rows) > 1 and deviation(rows[1:], true).worst <= atol

    @property
    def finite(self) -> bool:
        finite = all(rows is None or bool(np.isfinite(rows).all()) for rows in self.series.sensors)
        return finite and not self.series.unfilled

    @property
    def treated(self) -> bool:
        """Return whether the code rounded the true rows or mapped them linearly: fault `rows-altered`; False if it altered none."""
        keys = self.push.altered if self.push is not None else ()
        pairs = dict(zip(SENSORS, zip(self.series.sensors, self.true_rows, strict=True), strict=True))
        known = [(key, got, true) for key, (got, true) in pairs.items() if key in keys and got is not None]
        return bool(known) and all(treatment(key, got, true) is not None for key, got, true in known)

    @property
    def nearly(self) -> bool:
        """Return whether no row errs by more than the sheet's noise (1 sigma): then altered rows cost half of `matches_truth`."""
        both = zip(self.series.sensors, self.true_rows, SHEETS_NOISE, strict=True)
        return all(rows is not None and deviation(rows, true).worst <= little for rows, true, little in both)

    @property
    def late(self) -> int:
        """Samples by which rows lag behind the simulation (negative: lead), 1 if read before the step.

        It is 0 if the time stamps are off by as much, so that each row fits its stamp.
        """
        lag, series, step = self.push.lag if self.push else 0, self.series, self.facts.push.model_timestep
        if lag < -1 or not lag or series.time is None or series.acceleration is None or len(series.time) < 2:
            return lag
        if lag == -1:
            return 0 if abs(series.time[0] - step) < TIME_ATOL else lag
        at_once = np.abs(series.acceleration[0] - self.true_rows[0][0]).max() <= ATOL_ACCELERATION
        own = at_once and abs(series.time[0]) < TIME_ATOL and abs(series.time[1] - step) < TIME_ATOL
        return 0 if own else lag

    @property
    def first_row_is_zero(self) -> bool:
        return self.series.acceleration is not None and not self.series.acceleration[0].any()

    @property
    def skips_steps(self) -> bool:
        """Return whether rows skip steps and end too early or late: `samples-skipped`; if they end right, `sample_count` judges."""
        return (
            self.push is not None
            and self.push.skip != 1
            and not self.push.covers(self.facts.push.length, self.facts.push.model_steps)
        )

    @property
    def steps_beyond_rows(self) -> int:
        """Simulated steps minus rows, to tell faults apart: -1 if the first row is left empty, many if a robot settles first."""
        return int(self.series.first_step.get("steps", np.zeros(1))[0]) - self.facts.push.length

    @property
    def model_changed(self) -> str:
        """The time step or gravity that the code set for the run and restored, in words; "" if none, or if it was not restored.

        If the code does not restore it, the check `starts_from_reset` deducts that.
        """
        claim = self.push_claim
        if claim is None or not self.plain or self.series.changed:
            return ""
        if differ(np.array(claim.timestep), self.facts.push.model_timestep):
            return f"a time step of {claim.timestep:g} s"
        other = np.abs(claim.gravity - self.facts.gravity).max() > _GRAVITY_ATOL
        return f"a gravity of {vector(claim.gravity)} m/s²" if other else ""

    # ---- start of a run

    @property
    def second_is_empty(self) -> bool:
        """Return whether only the second recording has no rows, despite its duration: `ignores-duration`; False if it failed."""
        return self.facts.later is not None and self.facts.push.length > 0 and not self.facts.later.length

    @property
    def model_left_changed(self) -> str:
        return ", ".join(dict.fromkeys(name for run in self.facts.runs for name in run.series.changed))

    @property
    def rows_left(self) -> int:
        """Largest number of rows of an earlier run that a recording begins with, the fault `keeps-old-rows`; 0 if none does."""
        return max(run.left for run in self.facts.runs)

    @property
    def push_claim(self) -> Claim | None:
        """The start of the first run (state, gravity, time step, forces) as the worker reports it; None if it is right or unknown.

        The start counts as right if the rows come from a simulation with the lab sheet's push; but not if the robot stands still
        for many steps and is pushed only then.
        """
        return Claim.of(self.series.first_step) if self._settles_first else _claim_of(self.push, self.facts.push)

    @property
    def _settles_first(self) -> bool:
        """Return whether the robot only stands for many steps before the push, without a reset between them."""
        start = self.series.first_step
        if not start or start["qvel"].any() or not len(start["set_at"]) or start["set_at"][0] < FEWEST_ROWS:
            return False
        return self.steps_beyond_rows >= FEWEST_ROWS and all(
            differ(qpos, self.facts.start) for qpos in start["set_qpos"]
        )

    @property
    def goes_on(self) -> bool:
        """Return whether the second run continues an earlier one, or either run starts in another state than reset: `no-reset`."""
        later, left_at = self.facts.later, self.facts.left_at
        # The stamps of both runs may begin late, by the same time or by as many steps.
        late = _first_stamp(self.facts.push)
        in_steps = late * later.timestep / self.facts.push.timestep if later is not None else late
        if all(abs(_first_stamp(later) - each - left_at) < 0.5 * left_at for each in (0.0, late, in_steps)):
            return True
        claims = [self.push_claim, *([_claim_of(self.later, later)] if later is not None else [])]
        poses = [self.facts.start if claim is None else claim.qpos for claim in claims]
        if self.without_push and not differ(poses[0], poses[-1]):
            return False  # moved in the place of a push
        return any(differ(pose, self.facts.start) for pose in poses) or (
            self.other_velocities and not self.pushed_apart
        )

    @property
    def other_velocities(self) -> bool:
        """Return whether the second run starts with other velocities than the first; `pushed_apart` tells if the push is random."""
        first = self.series.first_step
        claim = _claim_of(self.later, self.facts.later) if self.facts.later is not None else None
        return claim is not None and self.later is not None and bool(first) and differ(claim.qvel, first["qvel"])

    @property
    def pushed_apart(self) -> bool:
        """Return whether two runs from a fresh state start with different velocities: the fault `random-push`."""
        return bool(self.facts.velocities) and differ(*self.facts.velocities)

    @property
    def without_push(self) -> bool:
        return self.push_claim is not None and self.push_claim.without_push

    @property
    def another_push(self) -> str:
        """How the first recording starts, in words, for the check `applies_push`; "" if with the lab sheet's push or if unknown."""
        if self.pushed_apart and self.push_claim is not None:
            first, second = map(velocities_in_words, self.facts.velocities)
            return f"a recording that starts with {first}, and the next one with {second}"
        return self.push_claim.push if self.push_claim is not None else ""


def _first_stamp(run: Run | None) -> float:
    """Return the first time stamp in seconds, which tells a run that continues another; NaN without a run or stamps."""
    time = run.series.time if run is not None else None
    return float(time[0]) if time is not None and len(time) else np.nan


def _claim_of(origin: RowOrigin | None, run: Run) -> Claim | None:
    """Return the reported start of a run that the true run does not explain; None if it does, or if no start was simulated."""
    return run.claim if origin is None or origin.world != TRUE_WORLD else None


_GRAVITY_ATOL = 1e-3
"""m/s². Code that writes the model's own gravity again with three decimals has not changed it."""


def counting_fault(first: Run, second: Run, *, skips: bool) -> str:
    """Return the id of the fault that the numbers of rows of two runs show, such as "ignores-duration"; "" for none.

    The runs differ in the duration that was asked for. `skips` is whether rows leave out steps: then the fault is "fixed-rate" if
    both runs have as many rows a second, else "samples-skipped".
    """
    n, m, a, b = first.length, second.length, first.duration_s, second.duration_s
    if skips:
        return "fixed-rate" if abs(n / a - m / b) <= 1 / min(a, b) else "samples-skipped"
    same_time = abs(n * first.timestep - m * second.timestep) <= max(first.timestep, second.timestep)
    if n == m or (same_time and abs(n - first.steps) > 1):
        return "ignores-duration"
    return "hard-coded-timestep" if abs(n / a - m / b) <= 1 / b else ""


def has_timestep(time: Array, timestep: float, usual: float) -> bool:
    """Return whether time stamps are `usual` seconds apart although the run's `timestep` is another: a hard-coded time step."""
    apart = np.abs(np.diff(time) - usual)
    return len(apart) > 0 and bool(apart.max() <= TIME_ATOL) and abs(timestep - usual) > TIME_ATOL
