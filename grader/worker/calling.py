"""Call a student's function with the lab sheet's arguments, matched to its own parameters by name, meaning or position.

A function whose parameters have other names, another order or one parameter more still does its job. So it is called as its own
signature asks. Where it differs from the sheet is reported beside its result, as one fault for all of its calls.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

_VARIADIC = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
_POSITIONAL = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)


@dataclass(frozen=True)
class Slot:
    """One argument of a call by the grader, and the rules by which a parameter of the student's function is found for it.

    Attributes
    ----------
    name : the parameter's name on the lab sheet
    meaning : regular expression, searched in a parameter's name, for other names that mean the same
    passed : ``position``, as on the sheet; ``option``: by keyword, left out if no parameter takes it; ``spare``: not on the sheet,
        passed only if a parameter asks for it
    replaces : a spare is passed to a parameter with a default only if the default has one of these types
    free : whether it is no fault if the function takes this argument otherwise than on the sheet
    anywhere : whether a positional parameter that is left over may get this argument, whatever its name
    """

    name: str
    meaning: re.Pattern[str]
    passed: Literal["position", "option", "spare"] = "position"
    replaces: tuple[type, ...] = ()
    free: bool = False
    anywhere: bool = False

    def suits(self, parameter: inspect.Parameter) -> bool:
        """Return whether a parameter's name fits; if `passed` is ``spare``, a default, if any, must have a type in `replaces`."""
        if parameter.name != self.name and not self.meaning.search(parameter.name):
            return False
        needed = parameter.default is parameter.empty
        return self.passed != "spare" or needed or isinstance(parameter.default, self.replaces)


@dataclass(frozen=True)
class CallPlan:
    """How to call one student's function: which slot (argument of the grader) each parameter gets, and where the function differs.

    Attributes
    ----------
    positions : names of the slots that are passed by position, in order
    names : parameter name -> name of the slot passed to it by keyword
    departs : names of the slots that the function takes out of order, by another keyword, in addition to the sheet's, or not at all
    as_promised : whether the call is exactly the lab sheet's, because it fits the function or because no call does
    """

    positions: tuple[str, ...]
    names: Mapping[str, str] = field(default_factory=dict)
    departs: tuple[str, ...] = ()
    as_promised: bool = False

    def __call__(self, function: Callable[..., Any], values: Mapping[str, Any]) -> Any:
        """Call the function. `values` maps slot names to arguments; a parameter whose slot has no value keeps its default."""
        named = {own: values[slot] for own, slot in self.names.items() if slot in values}
        return function(*(values[slot] for slot in self.positions if slot in values), **named)


def plan_call(function: Callable[..., Any], slots: Sequence[Slot]) -> CallPlan:
    """Return how to call a function with arguments (`slots`): as on the lab sheet, or by its own parameters if only that fits."""
    promised = CallPlan(
        tuple(slot.name for slot in slots if slot.passed == "position"),
        {slot.name: slot.name for slot in slots if slot.passed == "option"},
        as_promised=True,
    )
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return promised
    parameters = [p for p in signature.parameters.values() if p.kind not in _VARIADIC]
    if _accepts(signature, promised) and not any(s.passed == "spare" and s.suits(p) for s in slots for p in parameters):
        return promised
    claims = _assign_slots(parameters, slots)
    if any(p.default is p.empty and p.name not in claims for p in parameters):
        return promised
    leading = [p.name for p in parameters if p.kind is p.POSITIONAL_ONLY]
    return CallPlan(
        tuple(claims[name].name for name in leading if name in claims),
        {own: slot.name for own, slot in claims.items() if own not in leading},
        _departures(claims, slots),
    )


def has_place_for(slot: Slot, function: Callable[..., Any]) -> bool:
    """Return whether a function takes a slot (argument), by a fitting parameter or ``**kwargs``; True for an unknown signature."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return True
    return any(parameter.kind is parameter.VAR_KEYWORD or slot.suits(parameter) for parameter in parameters)


def adapt(
    function: Callable[..., Any], slots: Sequence[Slot], spares: Mapping[str, Any] | None = None
) -> tuple[Callable[..., Any], list[str]]:
    """Return `function` adapted to the lab sheet's positional arguments, and the names of slots in which it departs from the sheet.

    `slots` are all arguments, `spares` {slot's name: value} of those not on the sheet. A function is returned unchanged, with an
    empty list, if it fits or if no call does.
    """
    way = plan_call(function, slots)
    if way.as_promised:
        return function, []
    names = [slot.name for slot in slots if slot.passed == "position"]
    return lambda *given: way(function, {**(spares or {}), **dict(zip(names, given, strict=True))}), list(way.departs)


def _accepts(signature: inspect.Signature, promised: CallPlan) -> bool:
    """Return whether the sheet's call fits a signature, and each positional argument meets the parameter of its name, if any."""
    try:
        bound = signature.bind(*promised.positions, **promised.names).arguments
    except TypeError:
        return False
    return all(bound.get(name) == name for name in promised.positions if name in signature.parameters)


def _assign_slots(parameters: Sequence[inspect.Parameter], slots: Sequence[Slot]) -> dict[str, Slot]:
    """Return the slot (argument) for each parameter name: by name, by meaning, by position if required, then by `Slot.anywhere`."""
    claims: dict[str, Slot] = {}
    for suits in (_by_name, Slot.suits, _by_position, _by_leftover):
        for parameter in parameters:
            free = (slot for slot in slots if slot not in claims.values() and suits(slot, parameter))
            if parameter.name not in claims and (slot := next(free, None)):
                claims[parameter.name] = slot
    return claims


def _by_name(slot: Slot, parameter: inspect.Parameter) -> bool:
    return slot.name == parameter.name and slot.suits(parameter)


def _by_position(slot: Slot, parameter: inspect.Parameter) -> bool:
    return slot.passed == "position" and parameter.default is parameter.empty and parameter.kind in _POSITIONAL


def _by_leftover(slot: Slot, parameter: inspect.Parameter) -> bool:
    return slot.anywhere and parameter.kind in _POSITIONAL


def _departures(claims: Mapping[str, Slot], slots: Sequence[Slot]) -> tuple[str, ...]:
    """Return the names of the slots (arguments) that a function takes out of order, renamed, beyond the lab sheet, or not at all.

    An option that no parameter takes is not listed: its effect shows in the results.
    """
    promised = [slot for slot in slots if slot.passed == "position"]
    taken = [slot for slot in claims.values() if slot.passed == "position"]
    in_order = [slot for slot in promised if slot in taken]
    odd = [slot for slot in promised if slot not in taken]
    odd += [slot for slot, other in zip(in_order, taken, strict=True) if slot is not other]
    odd += [slot for own, slot in claims.items() if slot.passed == "option" and own != slot.name]
    odd += [slot for slot in claims.values() if slot.passed == "spare"]
    return tuple(slot.name for slot in odd if not slot.free)
