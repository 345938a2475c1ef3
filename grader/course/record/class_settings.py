"""Settings of a class in its database: rubric, roster, attempt rule, scenarios (simulated motions) and isolation level.

A later command uses them as defaults. Options that differ are compared with them, and their effect on the scores is computed before
anything is changed.
"""

from __future__ import annotations

import json
import statistics
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from datetime import tzinfo
from pathlib import Path
from typing import Any

from grader import __version__
from grader.base.errors import RequestError
from grader.engine.lab import Lab
from grader.engine.lab_registry import DEFAULT
from grader.engine.marks import fits, marked
from grader.engine.rubric import OwnChecks, Rubric, load, parse
from grader.engine.traces import Traces
from grader.people import late_policy, roster
from grader.people.final_grade import FinalGrade, HandIn, Person, grade_changes
from grader.people.roster import NO_ROSTER, Roster
from grader.report.causes import stops

_SCENARIOS = "other scenarios (another secret or model, or another version of MuJoCo or imugrade)"


@dataclass(frozen=True)
class ClassSettings:
    """Settings that a class is graded by, stored with the results so that later commands use or compare them.

    Attributes
    ----------
    rubric, rubric_source, rubric_folder, own_checks
        The whole text of the rubric, the name of its file, the folder in which its relative paths start, and name and content
        of each file of the instructor's own checks.
    rubric_sha256, late
        Digest of all in the rubric that scores depend on, and its late policy as text.
    roster, roster_source
        The whole text of the roster, "" where there is none, and the name of its file.
    attempts
        Which of several attempts counts: "latest" or "best".
    traces_sha256, hidden
        Digest of the scenarios and the robot's model file, to notice a change of either; whether the scenarios are hidden, made
        from a secret. A reader of the digest can test guesses at the secret, some seconds each.
    grader
        Version of imugrade.
    isolation
        Weakest isolation level that a submission of the class was graded at; "" before the first one.
    repairs
        Whether `grade` applies suggested repairs.
    lab
        Id of the lab.
    """

    rubric: str
    rubric_source: str
    rubric_folder: str
    own_checks: OwnChecks
    rubric_sha256: str
    late: str
    roster: str
    roster_source: str
    attempts: str
    traces_sha256: str
    hidden: bool
    grader: str = __version__
    isolation: str = ""
    repairs: bool = False
    lab: str = DEFAULT

    @classmethod
    def of(cls, rubric: Rubric, people: Roster, attempts: str, traces: Traces) -> ClassSettings:
        """Return settings from a rubric (with its lab and repairs), roster, `attempts` and traces; the caller sets `isolation`."""
        return cls(
            **_of_rubric(rubric),
            roster=people.text,
            roster_source=people.source,
            attempts=attempts,
            traces_sha256=traces.sha256,
            hidden=traces.name != "public",
            lab=rubric.lab.id,
        )

    @property
    def has_late_policy(self) -> bool:
        return self.late != repr(None)

    def with_rubric(self, rubric: Rubric) -> ClassSettings:
        """Return a copy of these settings with another rubric, for a class that is regraded by it."""
        return replace(self, **_of_rubric(rubric))


def _of_rubric(rubric: Rubric) -> dict[str, Any]:
    """Return the fields of `ClassSettings` that come from the rubric, for new settings and for a change of rubric."""
    return {
        "rubric": rubric.text,
        "rubric_source": rubric.source,
        "rubric_folder": str(Path(rubric.folder or "").absolute()),
        "own_checks": rubric.own_checks,
        "rubric_sha256": rubric.sha256,
        "late": repr(rubric.late),
        "repairs": rubric.repairs.suggested,
    }


def to_json(settings: ClassSettings) -> str:
    own = [(name, content.decode("utf-8", "surrogateescape")) for name, content in settings.own_checks]
    return json.dumps({**asdict(settings), "own_checks": own}, ensure_ascii=True)


def from_json(text: str) -> ClassSettings:
    """Parse JSON from `to_json`; drop unknown fields, give missing ones their default, if any. `database.read` catches errors."""
    record = json.loads(text)
    own = tuple((name, content.encode("utf-8", "surrogateescape")) for name, content in record["own_checks"])
    known = {field.name for field in fields(ClassSettings)}
    return ClassSettings(**{**{name: value for name, value in record.items() if name in known}, "own_checks": own})


def rubric_of(lab: Lab, settings: ClassSettings | None, path: Path | None = None) -> Rubric:
    """Return the rubric of a class: the file at `path`, else the one in its settings, else the one shipped with the lab.

    RubricError if the rubric has problems.
    """
    if path is not None or settings is None:
        return load(lab, path)
    data = settings.rubric.encode("utf-8", "surrogateescape")
    folder, own = Path(settings.rubric_folder), settings.own_checks
    return parse(lab, data, source=settings.rubric_source, folder=folder, own=own)


def absent(settings: ClassSettings | None, hand_ins: Mapping[str, HandIn]) -> list[Person]:
    """Return the people of the roster not named in `hand_ins` (by submission id), to list as missing; empty without a roster."""
    known = {person for hand_in in hand_ins.values() for person in hand_in.people}
    unplaced = roster.place(
        roster_of(settings).people, hand_ins
    ).absent  # also a person with points and a later hand-in
    return [listed.person for listed in unplaced if listed.person not in known]


def roster_of(settings: ClassSettings | None, path: Path | None = None, zone: tzinfo | None = None) -> Roster:
    """Return the roster of a class: the file at `path`, else the one in its settings; an empty roster without both.

    `zone` is the time zone of a Moodle worksheet's times, or None to ignore them. Any other time without an offset is an error.

    Raises
    ------
    RequestError
        If the file cannot be read as a roster.
    """
    if path is not None:
        return roster.load(path, zone)
    if settings is None or not settings.roster:
        return NO_ROSTER
    return roster.parse(settings.roster.encode("utf-8", "surrogateescape"), settings.roster_source, zone)


@dataclass(frozen=True)
class Change:
    """Effect of new settings on the scores of a class, shown to a person who then allows or refuses them.

    Attributes
    ----------
    causes
        What differs, in words.
    moved, of, means
        Of the stored submissions that need not run again: how many scores change, of how many, and their means before
        and after (None without scores).
    regraded
        How many submissions on record are graded again, with a result that is not known yet.
    chosen_anew
        Whether another of several attempts may count.
    left
        How many stored submissions are not among those to grade now, and stay as they are.
    to_repair
        How many stored submissions do not run and may get a repair.
    """

    causes: tuple[str, ...]
    moved: int = 0
    of: int = 0
    means: tuple[float, float] | None = None
    regraded: int = 0
    chosen_anew: bool = False
    left: int = 0
    to_repair: int = 0

    @property
    def moves_scores(self) -> bool:
        """Return whether a stored score changes or may change, which `grade` refuses unless a person allows it."""
        return bool(self.moved or self.regraded or self.chosen_anew or self.to_repair)

    def in_words(self) -> str:
        """Return one line for a person to decide by: what differs in the settings, and what that does to the scores."""
        effects = [f"{self.moved} of {self.of} scores change" if self.moved else "no score changes"] if self.of else []
        if self.moved and self.means:
            effects.append(f"mean of graded {self.means[0]:.1f} to {self.means[1]:.1f}")
        if self.regraded:
            effects.append(f"{self.regraded} on record {'is' if self.regraded == 1 else 'are'} graded again")
        if self.chosen_anew:
            effects.append("of several attempts another one may count")
        if self.to_repair:
            many = "1 that does" if self.to_repair == 1 else f"{self.to_repair} that do"
            effects.append(f"{many} not run may get a repair")
        if self.left and self.moves_scores:
            effects.append(
                f"{self.left} not in the download stay{'s' * (self.left == 1)} as {'it is' if self.left == 1 else 'they are'}"
            )
        return f"{', '.join(self.causes)}: {', '.join(effects) or 'nothing is on record'}"


def change(
    old: ClassSettings,
    new: ClassSettings,
    rubric: Rubric,
    everyone: Mapping[str, FinalGrade],
    hand_ins: Mapping[str, HandIn | None],
) -> Change | None:
    """Compute what new settings of a class do to its stored scores, for a person to decide; None if no score depends on the change.

    Parameters
    ----------
    rubric
        The rubric of the new settings.
    everyone
        The stored final grade of every submission, by id.
    hand_ins
        By id of each submission to grade: who handed it in and when, with the new roster. None if it has several attempts: the
        stored hand-in is used, and under a new attempt rule another one may count (`Change.chosen_anew`).
    """
    differences = causes(old, new)
    if not differences:
        return None
    final_grades = {id_: each for id_, each in everyone.items() if id_ in hand_ins}
    again = (old.traces_sha256, old.grader) != (new.traces_sha256, new.grader)
    same = old.rubric_sha256 == new.rubric_sha256
    kept = {} if again else {id_: each for id_, each in final_grades.items() if same or fits(each.result, rubric)}
    known_of = hand_ins if old.roster != new.roster else {}
    after = {
        id_: late_policy.judged_again(
            replace(
                each,
                result=each.result if same else marked(each.result, rubric),
                hand_in=known_of.get(id_) or each.hand_in,
            ),
            rubric.late,
        )
        for id_, each in kept.items()
    }
    graded = [(kept[id_].final, each.final) for id_, each in after.items() if each.result.status == "graded"]
    known = [(was, now) for was, now in graded if was is not None and now is not None]
    means = (statistics.fmean(was for was, _ in known), statistics.fmean(now for _, now in known)) if known else None
    broken = (each for each in kept.values() if not each.result.repairs and stops(each.result, rubric.lab))
    to_repair = sum(1 for _ in broken) if new.repairs and not old.repairs else 0
    several = new.attempts == "latest" or None in hand_ins.values()
    chosen_anew = old.attempts != new.attempts and several and bool(final_grades)
    return Change(
        differences,
        len(grade_changes(kept, after)),
        len(after),
        means,
        len(final_grades) - len(kept),
        chosen_anew,
        len(everyone) - len(final_grades),
        to_repair,
    )


def causes(old: ClassSettings, new: ClassSettings) -> tuple[str, ...]:
    """Say in words what differs between two settings of a class; empty if no score depends on the differences."""
    rubric = "another rubric" if old.rubric_sha256 != new.rubric_sha256 else "another late policy"
    found = {
        rubric: (old.rubric_sha256, old.late) != (new.rubric_sha256, new.late),
        f"repairs are {'' if new.repairs else 'not '}applied by themselves": old.repairs != new.repairs,
        "another roster" if old.roster else "a roster": old.roster != new.roster,
        f"another attempt rule ({new.attempts} in place of {old.attempts})": old.attempts != new.attempts,
        _SCENARIOS: old.traces_sha256 != new.traces_sha256,
        f"another version of imugrade ({new.grader} in place of {old.grader})": old.grader != new.grader,
    }
    return tuple(words for words, differs in found.items() if differs)


def others(settings: ClassSettings, final_grades: Mapping[str, FinalGrade]) -> list[str]:
    """Return the ids of submissions graded by another rubric or scenarios than the class, as an interrupted change leaves them."""
    mine = {"rubric_sha256": settings.rubric_sha256, "traces_sha256": settings.traces_sha256}
    return [
        id_
        for id_, final_grade in final_grades.items()
        if not final_grade.has_no_submission
        and any(final_grade.result.provenance.get(name) != digest for name, digest in mine.items())
    ]


def refuse_without_secret(old: ClassSettings | None, seed: str | None) -> None:
    """Refuse to grade on public scenarios a class that was graded on hidden ones: the scores could not be compared.

    RequestError if the stored settings `old` have hidden scenarios, and `seed`, the secret that makes them, is None. Before the
    first run `old` is None, and nothing is refused.
    """
    if old is not None and old.hidden and seed is None:
        raise RequestError(
            "the class on record was graded on hidden scenarios; set IMUGRADE_SEED to the secret that it was graded with, or grade "
            "into another folder with -o"
        )


def refuse_other_scenarios(old: ClassSettings | None, traces: Traces) -> None:
    """Refuse to grade one submission, such as a repaired one, on other scenarios than the hidden ones of its class.

    RequestError if the stored settings `old` have hidden scenarios, and `traces` others, as from a wrong secret. A class with
    public scenarios, or without settings (`old` None), is not checked here.
    """
    if old is not None and old.hidden and old.traces_sha256 != traces.sha256:
        raise RequestError(
            f"the class on record was graded on {_SCENARIOS}; set IMUGRADE_SEED to the secret of this class, or grade all of it "
            "again with `imugrade grade --change`"
        )
