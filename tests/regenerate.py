"""Write every generated file of the repository anew: `python -m tests.regenerate`; a minute once the recordings are there.

Read the difference before you commit it: these files pin marks and messages. A test that finds one of them stale prints this command.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from tests import examples
from tests.judging import fake_students
from tests.recordings import losses

ROOT = Path(__file__).parents[1]
GENERATED: dict[Path, Callable[[], str]] = {
    fake_students.WORDS: fake_students.all_words,
    losses.FILE: losses.all_losses,
    examples.TABLE: examples.table,
}


def main() -> int:
    argparse.ArgumentParser(prog="python -m tests.regenerate", description=__doc__).parse_args()
    for path in regenerated():
        print(path.relative_to(ROOT))
    return 0


def regenerated() -> Iterator[Path]:
    """Write each file whose content has changed."""
    for path, content in GENERATED.items():
        text = content()
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            yield path


if __name__ == "__main__":
    sys.exit(main())
