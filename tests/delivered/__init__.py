"""What pip installs, tried from an empty folder by an ordinary user: ``python -m pytest -m delivered -n 0`` (needs the package index)."""
