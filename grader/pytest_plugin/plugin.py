"""Add two options to pytest. Everything else is imported only when `--imugrade` is given."""

from __future__ import annotations

import pytest


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
    """Load no `conftest.py` with `--imugrade`: it would be student code in the grader's process."""
    if early_config.known_args_namespace.imugrade:
        early_config.known_args_namespace.noconftest = True


def pytest_configure(config: pytest.Config) -> None:
    if config.option.imugrade:
        from grader.pytest_plugin.items import PluginRun  # noqa: PLC0415

        config.pluginmanager.register(PluginRun(config), "imugrade-run")
