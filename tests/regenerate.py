"""Write every generated file of the repository anew: `python -m tests.regenerate`; a minute once the recordings are there.

`python -m tests.regenerate docs` writes only the tables of the documentation, in seconds.

Read the difference before you commit it: these files pin marks and messages. A test that finds one of them stale prints this command.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from docs import generated
from tests import calibrated, examples
from tests.judging import fake_students
from tests.recordings import losses

ROOT = Path(__file__).parents[1]
GENERATED: dict[Path, Callable[[], str]] = {
    fake_students.WORDS: fake_students.all_words,
    losses.FILE: losses.all_losses,
    examples.TABLE: examples.table,
    calibrated.TABLE: calibrated.table,
    **{generated.FOLDER / page: partial(generated.fill, text) for page, text in generated.pages().items()},
}


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.regenerate", description=__doc__)
    parser.add_argument("paths", nargs="*", type=Path, default=[ROOT], help="only the files in these folders")
    for path in regenerated([given.resolve() for given in parser.parse_args().paths]):
        print(path.relative_to(ROOT))
    return 0


def regenerated(wanted: list[Path]) -> Iterator[Path]:
    """Write each file below the wanted paths whose content has changed."""
    for path, content in GENERATED.items():
        if not any(path.is_relative_to(each) for each in wanted):
            continue
        text = content()
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            yield path


if __name__ == "__main__":
    sys.exit(main())
