"""What is told of a definition that does not fit in as the sheet's does: as it can be shown, and cut, with its place."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from grader.engine.findings import Fault, Lost, Where
from grader.engine.slips import Slip
from grader.ground.text import printable
from grader.labs.imu.checks.fitting import fits_in

pytestmark = pytest.mark.quick
OWN, MEANT, SAID = "Low\x1bPass" + "s" * 80, "High\x1b" + "t" * 80, "it is \x1b" + "no" * 200


def _lost(**answers: Any) -> Lost:
    known: dict[str, Any] = {
        "completed_in": (),
        "slips_in": (),
        "lent_to": (),
        "misspelt": ("", ""),
        "returns_nothing": False,
    }
    student: Any = SimpleNamespace(
        **{name: lambda _, value=value: value for name, value in (known | answers).items()}  # type: ignore[misc]
    )
    with pytest.raises(Lost) as lost:
        fits_in(student, "LowPassFilter", ())
    return lost.value


def test_a_misspelt_name() -> None:
    assert _lost(misspelt=("LowPassFilter", OWN)).got == f"{printable(OWN, 60)}, which was taken for LowPassFilter"
    assert "\x1b" not in printable(OWN, 60)


def test_what_python_refuses() -> None:
    first, second = (
        Fault("SyntaxError", SAID, "filters.py", 3, None),
        Fault("IndentationError", "no", "filters.py", 9, None),
    )
    lost = _lost(completed_in=(first, second))
    assert lost.got == f"SyntaxError: {printable(SAID, 200)} at filters.py, line 3; mended, so that the rest counts"
    assert lost.where == Where("filters.py", 3)


def test_what_a_function_stops_at() -> None:
    first, second = Slip("a.py", 1, 4, "index", OWN, MEANT), Slip("b.py", 2, 9, "expression", "gian", MEANT)
    lost = _lost(slips_in=(first, second, first))
    assert lost.expected == printable(MEANT, 60)
    assert (
        lost.got == f"{printable(OWN, 60)}, gian at a.py, line 4, which it stops at; taken for {printable(MEANT, 60)}"
    )
    assert (lost.mistakes, lost.where) == (("raises",), Where("a.py", 4))


def test_what_was_left_out_is_told_after_what_was_mended() -> None:
    left, mended = Slip("a.py", 1, 4, "left out", OWN, MEANT), Slip("b.py", 2, 9, "whole", "n", "int(n)")
    lost = _lost(slips_in=(left, mended))
    assert (lost.expected, lost.mistakes) == ("int(n)", ("raises",))
    lost = _lost(slips_in=(left,))
    assert lost.expected == "no exception"
    assert (
        lost.got
        == f"{printable(MEANT, 200)} at a.py, line 4; {printable(OWN, 60)} was left out, so that the rest counts"
    )
    assert (lost.mistakes, lost.where) == (("raises",), Where("a.py", 4))


@pytest.mark.parametrize("kind", ["asked", "compared"])
def test_an_array_that_is_asked_whether_it_is_there_has_a_name(kind: str) -> None:
    assert _lost(slips_in=(Slip("a.py", 1, 4, kind, "own", "meant"),)).mistakes == ("array-asked-for-truth",)


def test_a_package_that_is_not_here_has_a_name_where_what_draws_with_it_is_left_out() -> None:
    raised = Slip("a.py", 1, 4, "left out", "sns.lineplot()", "ModuleNotFoundError: No module named 'seaborn'")
    assert _lost(slips_in=(raised,)).mistakes == ("missing-package",)


@pytest.mark.parametrize(
    "kind", ["expression", "keyword", "kept", "self", "index", "whole", "shape", "appended", "called"]
)
def test_which_of_them_is_a_name(kind: str) -> None:
    named = ("unknown-name",) if kind in ("expression", "keyword", "kept", "self") else ("raises",)
    assert _lost(slips_in=(Slip("a.py", 1, 4, kind, "own", "meant"),)).mistakes == named


def test_two_globals_in_place_of_what_is_given() -> None:
    student: Any = SimpleNamespace(
        completed_in=lambda _: (),
        slips_in=lambda _: (),
        lent_to=lambda _: (),
        misspelt=lambda _: ("", ""),
        returns_nothing=lambda _: False,
    )
    with pytest.raises(Lost) as lost:
        fits_in(
            student, "get_imu_readings", ("global model", "global data"), belongs_to="sensor_access.follows_address"
        )
    assert (lost.value.got, lost.value.keeps) == ("a global in place of model and data", 0.5)
    assert (lost.value.mistakes, lost.value.belongs_to) == (
        ("global-for-parameter",),
        ("sensor_access.follows_address",),
    )
