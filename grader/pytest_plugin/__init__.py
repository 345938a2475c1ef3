"""pytest plugin: `pytest --imugrade` shows the checks of a submission as ordinary tests."""
