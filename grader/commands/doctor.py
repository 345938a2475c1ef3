"""`imugrade doctor`: what this machine can do."""

from __future__ import annotations

from grader.commands.common import console


def doctor() -> int:
    """Show the isolation levels and versions of this machine."""
    from grader.commands import machine as doctors  # noqa: PLC0415
    from grader.report import terminal  # noqa: PLC0415

    terminal.show_findings(doctors.examine(), console())
    return 0
