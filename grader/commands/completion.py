"""Tab completion: criteria, and everything that `imugrade explain` explains. Nothing is read before Tab is pressed."""

from __future__ import annotations

from grader.labs.imu.lab import LAB


def criteria(incomplete: str) -> list[str]:
    """Return the criteria and extensions."""
    return _starting_with(incomplete, list(LAB.titles))


def checks(incomplete: str) -> list[str]:
    """Return the ids of the checks."""
    from grader.engine import rubric  # noqa: PLC0415

    return _starting_with(incomplete, [weight.id for weight in rubric.load(LAB).checks])


def explained(incomplete: str) -> list[str]:
    """Return every fault, criterion, extension and check."""
    from grader.engine.faults import catalogue  # noqa: PLC0415

    return _starting_with(incomplete, [*catalogue(LAB), *LAB.titles, *checks("")])


def _starting_with(incomplete: str, words: list[str]) -> list[str]:
    return [word for word in words if word.startswith(incomplete)]
