"""Add the options `--imugrade` and `--imugrade-rubric` to pytest. All else is imported only when `--imugrade` is given."""

from __future__ import annotations

from pathlib import Path

import pytest

EMPTY = Path(__file__).with_name("empty.ini")
"""Settings without any option, in place of those of a submission."""


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("imugrade", "a lab's checks as tests")
    group.addoption(
        "--imugrade",
        action="store_true",
        help="run the checks of the submission at PATH (default: this folder) as tests, and no others; its code is sandboxed",
    )
    group.addoption("--imugrade-rubric", metavar="FILE", help="another rubric.yaml")


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> None:
    """Load no `conftest.py` with `--imugrade`, and stop if pytest has read settings: both may run student code."""
    if not early_config.known_args_namespace.imugrade:
        return
    early_config.known_args_namespace.noconftest = True
    if early_config.inipath is not None and early_config.known_args_namespace.inifilename is None:
        from grader.base.text import printable  # noqa: PLC0415

        raise pytest.UsageError(
            f"imugrade: pytest has read {printable(str(early_config.inipath))}, and settings may run code. "
            f"Install imugrade anew, or name other settings: pytest --imugrade -c {EMPTY}"
        )


def pytest_configure(config: pytest.Config) -> None:
    if config.option.imugrade:
        from grader.pytest_plugin.items import PluginRun  # noqa: PLC0415

        config.pluginmanager.register(PluginRun(config), "imugrade-run")
