"""`python -m grader.handbook`: make the pages anew."""

from __future__ import annotations

from grader.cli import app
from grader.handbook.pages import write

if __name__ == "__main__":
    for path in write(app):
        print(path)
