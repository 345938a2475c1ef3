"""Terminal output of one result. Texts are `rich.text.Text`, so that nothing in them is read as markup."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from grader.base.text import printable
from grader.engine.lab import Lab
from grader.engine.results import CheckResult, CriterionResult, ExtensionResult, LabName, Result
from grader.report import causes, words
from grader.report.causes import Cause
from grader.report.earlier_points import EarlierPoints
from grader.report.lines import LABEL, Setting

WIDTH = 100
_BAR = 20  # columns
_NEVER_CALLED = frozenset({"file-missing", "name-missing", "does-not-import", "not-written"})
_STYLE = {"passed": "green", "partial": "yellow", "failed": "red", "blank": "bright_black"}


def show_line(line: Text, console: Console) -> None:
    """Print one line of a screen as it is laid out, without wrapping it or padding it to the width."""
    console.print(line, soft_wrap=True)


def screen(
    result: Result,
    console: Console,
    lab: Lab,
    *,
    only: str | None = None,
    before: Mapping[str, float] | None = None,
    command: str = "imugrade check",
    repeat: str = "",
    verbose: bool = False,
) -> list[Text]:
    """Return the lines of a result: code that does not run, totals, next step, deductions by cause, the command to run again.

    A cause is a fault (or a failure without a known fault) with its checks. Code that does not run, or else the first cause, is
    shown with all lines, others without *Read* and *Reproduce*. Passed checks are folded into one line with `only`, else into the
    totals, except those that have passed since the last run in a criterion or extension that still lacks points.

    Parameters
    ----------
    console
        The output. Lines have at most 100 columns on a terminal and are unbroken in a pipe.
    lab
        Supplies the functions that checks are about, and the files to hand in.
    only
        The id of the one criterion or extension to show, with all lines; None shows all.
    before
        The points of each check in the last run, by the check's id, to show what changed; None if there was no such run.
    command
        The command that was called, without options.
    repeat
        The command that writes a program to repeat a check without the grader, with ``{}`` for the check's id; "" shows none.
    verbose
        Show every cause with all lines, and each passed check.
    """
    setting = Setting(console, min(console.width, WIDTH) if console.is_terminal else None)
    parts = causes.parts_of(result, only)
    checks = [check for part in parts for check in part.checks]
    found = causes.causes_of(checks)
    earlier = EarlierPoints(before or {})
    broken = [cause for cause in found if cause.does_not_run]
    others = [cause for cause in found if not cause.does_not_run]
    whole = others if verbose or only is not None else others[: 0 if broken else 1]
    blocks = [
        [Text("Does not run", "bold")] if broken else [],
        *([*_cause(cause, result.lab, setting, earlier), *_repeat(cause, lab, repeat, setting)] for cause in broken),
        _totals(result, parts, setting, earlier, only) or _not_there(result, lab, only, setting),
        _next(found, lab, setting),
        _gained(parts, setting, earlier) if only is None and not verbose else [],
        *([*_cause(cause, result.lab, setting, earlier), *_repeat(cause, lab, repeat, setting)] for cause in whole),
        *(_cause(cause, result.lab, setting, earlier, read=False) for cause in others if cause not in whole),
        _without_verdict(checks, setting),
        _passed(checks, setting, verbose=verbose) if only is not None or verbose else [],
        _closing(result, setting),
        _hand_in(result, lab, setting) if only is None else [],
        [
            *_again(found, command, setting),
            *(_more(command, setting) if len(whole) < len(others) else []),
            *_help(result, setting),
        ],
    ]
    return [line for block in blocks if block for line in (Text(), *block)][1:]


def _totals(
    result: Result,
    parts: Sequence[CriterionResult | ExtensionResult],
    setting: Setting,
    earlier: EarlierPoints,
    only: str | None,
) -> list[Text]:
    """Return a line for each criterion or extension, and below them the score, unless only one criterion is shown."""
    rows = [_total_of(part, earlier) for part in parts]
    if only is None and parts:
        rows.append(_Total(" ", "Score", words.total_points(result), None, earlier.total_change(result.criteria)))
    if only is None and parts and words.extra_credit(result):
        rows.append(_Total(" ", "Extra credit", words.extra_credit(result), None, ""))
    titles = max((cell_len(row.title) for row in rows), default=0)
    points = max((len(row.points) for row in rows), default=0)
    return [_total(row, setting, titles, points) for row in rows]


def _not_there(result: Result, lab: Lab, only: str | None, setting: Setting) -> list[Text]:
    """Return the line that the one extension to show is not in the submission; [] for other results without rows."""
    homes = [part.home for part in lab.bonuses if part.id == only and result.status == "graded"]
    return setting.hang(Text(), Text(f"Nothing to check: there is no {homes[0]}", "bold")) if homes else []


@dataclass(frozen=True)
class _Total:
    """One line of the totals. `share` is the earned share, None if a check was not judged or the line needs no bar."""

    sign: str
    title: str
    points: str
    share: float | None
    changed: str


def _total_of(part: CriterionResult | ExtensionResult, earlier: EarlierPoints) -> _Total:
    if isinstance(part, ExtensionResult):
        earned = sum(check.outcome == "passed" for check in part.checks) / len(part.checks)
        title, points = f"Extension: {part.id.replace('_', ' ')}", words.extension_points(part)
        return _Total(_sign(earned), title, points, earned, earlier.change_of(part.checks))
    share = None if words.unjudged(part) or not part.max_points else part.points / part.max_points
    return _Total(
        _sign(share), printable(part.title, 300), words.criterion_points(part), share, earlier.change_of(part.checks)
    )


def _sign(share: float | None) -> str:
    if share is None:
        return "?"
    return "✓" if share >= 1 else "◐" if share > 0 else "✗"


def _total(row: _Total, setting: Setting, titles: int, points: int) -> Text:
    style = {"✓": "green", "◐": "yellow", "✗": "red"}.get(row.sign, "")
    title = Text(row.title, "bold")
    if setting.width is None:
        line = Text.assemble((f" {row.sign} ", style), title, "  ", row.points)
    else:
        title.pad_right(titles - cell_len(row.title))
        line = Text.assemble((f" {row.sign} ", style), title, "  ")
        if setting.bars:
            line.append(_bar(row.share), style).append("  ")
        line.append(row.points.rjust(points))
    return line.append(f"  {row.changed}" if row.changed else "", "bold")


def _bar(share: float | None) -> str:
    if share is None:
        return " " * _BAR
    full = int(share * _BAR)  # a bar is full where nothing is missing
    return "█" * full + "░" * (_BAR - full)


def _next(found: Sequence[Cause], lab: Lab, setting: Setting) -> list[Text]:
    step = causes.next_step(found, lab)
    return setting.hang(Text("Next  ", LABEL), Text(step, "bold")) if step else []


def _passed(checks: Sequence[CheckResult], setting: Setting, *, verbose: bool) -> list[Text]:
    """Return the lines of the passed checks, folded into one line unless `verbose`; [] without any."""
    passed = [check for check in checks if check.outcome == "passed"]
    if verbose or not passed:
        return [line for check in passed for line in _head(check, setting)]
    points = words.fraction(sum(check.points or 0.0 for check in passed), sum(check.max_points for check in passed))
    return setting.head(_outcome(passed[0]), f"{len(passed)} check{'s' * (len(passed) > 1)}", points)


def _gained(parts: Sequence[CriterionResult | ExtensionResult], setting: Setting, earlier: EarlierPoints) -> list[Text]:
    """Return the lines of checks that have passed since the last run, without those of a complete part, whose total says so."""
    open_ = [part for part in parts if part.points < part.max_points]
    gained = [
        check for part in open_ for check in part.checks if check.outcome == "passed" and earlier.points_before(check)
    ]
    return [line for check in gained for line in _head(check, setting, earlier.points_before(check))]


def _head(check: CheckResult, setting: Setting, was: str = "") -> list[Text]:
    return setting.head(_outcome(check), words.row(check, "", LabName()).title, causes.points_of(check) + was)


def _outcome(check: CheckResult) -> Text:
    outcome = words.row(check, "", LabName()).outcome
    return Text(f" {outcome.sign} {outcome.word}", _STYLE[outcome.kind])


def _cause(cause: Cause, lab: LabName, setting: Setting, earlier: EarlierPoints, *, read: bool = True) -> list[Text]:
    """Return the lines of one fault: its checks with what came, their points together, what to try and, if `read`, to read."""
    lines: list[Text] = []
    for check, news in causes.lines_by_check(cause):
        lines += _head(check, setting, earlier.points_before(check))
        lines += [line for text in news for line in setting.labelled(text.label, text.text)]
    if len(cause.checks) > 1 and not cause.does_not_run:
        lines += setting.labelled("Costs", f"{words.counted_points(cause.lost)} together")
    for line in causes.next_lines(cause, lab):
        if read or line.label != "Read":
            lines += setting.labelled(line.label, line.text)
    return lines


def _repeat(cause: Cause, lab: Lab, repeat: str, setting: Setting) -> list[Text]:
    """Return how to repeat a check without the grader; [] if that is not possible, as for code that was never called."""
    first = cause.checks[0]
    call = lab.call_of(first.id)
    if not repeat or not call or not _NEVER_CALLED.isdisjoint(first.misconceptions):
        return []
    return setting.labelled("Reproduce", f"{repeat.format(first.id)}\nwith the same input as here: {call}")


def _without_verdict(checks: Sequence[CheckResult], setting: Setting) -> list[Text]:
    """Return a line for the skipped checks and one for each reason why checks were not judged."""
    reasons: dict[str, list[CheckResult]] = {}
    for check in checks:
        if check.outcome in ("skipped", "not_judged"):
            skipped = check.outcome == "skipped"
            reason = "not graded until the checks above are fixed" if skipped else printable(check.message, 300)
            reasons.setdefault(reason, []).append(check)
    return [line for reason, together in reasons.items() for line in _together(reason, together, setting)]


def _together(reason: str, checks: Sequence[CheckResult], setting: Setting) -> list[Text]:
    points = words.number(sum(check.max_points for check in checks))
    many = f"{len(checks)} check{'s' * (len(checks) > 1)}, {points} points"
    return setting.head(_outcome(checks[0]), f"{many}: {reason}", "")


def _closing(result: Result, setting: Setting) -> list[Text]:
    """Return the notes, then why there is no score. A submission without files has one line."""
    status = words.STATUS[result.status]
    if result.status in ("empty", "unreadable"):
        return setting.hang(Text(), Text(" ".join([f"{words.name(result)}: {status}", *words.notes(result)])))
    notes = [line for note in words.notes(result) for line in setting.hang(Text("Note  ", LABEL), Text(note))]
    return [*notes, *(setting.hang(Text(), Text(status, "bold")) if status else [])]


def _hand_in(result: Result, lab: Lab, setting: Setting) -> list[Text]:
    """Return the line that tells a student which files to hand in once all points are earned; [] before."""
    if result.status != "graded" or result.score < result.max_score:
        return []
    return setting.hang(Text("Hand in  ", LABEL), Text(", ".join((*lab.files, *lab.pictures))))


def _again(found: Sequence[Cause], command: str, setting: Setting) -> list[Text]:
    part = causes.next_part(found)
    return setting.hang(Text("Rerun  ", LABEL), Text(f"{command} --only {part}")) if part else []


def _help(result: Result, setting: Setting) -> list[Text]:
    found = words.help_lines(result)
    return [row for line in found for row in setting.hang(Text(f"{line.label}  ", LABEL), Text(line.text))]


def _more(command: str, setting: Setting) -> list[Text]:
    return setting.hang(Text("All lines  ", LABEL), Text(f"{command} -v"))
