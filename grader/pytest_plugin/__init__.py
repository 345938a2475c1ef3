"""The front door of pytest: `pytest --imugrade` shows the checks of a submission as ordinary tests."""
