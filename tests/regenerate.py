"""Write every generated file of the repository anew: `python -m tests.regenerate`; ten minutes once the recordings are there.

`python -m tests.regenerate docs` writes only the tables of the documentation, in seconds; `--only words` only the files with this
in their name; `--only ROW` only what the rows of the corpus with this in their name lose, in a second a row.

Read the difference before you commit it: these files pin marks and messages. A test that finds one of them stale prints this command.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
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
    **{generated.FOLDER / page: partial(generated.filled, page) for page in generated.pages()},
}


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.regenerate", description=__doc__)
    parser.add_argument("paths", nargs="*", type=Path, default=[ROOT], help="only the files in these folders")
    parser.add_argument(
        "--only", default="", metavar="NAME", help="only the files, or the rows of the corpus, with this in their name"
    )
    options = parser.parse_args()
    wanted = chosen([given.resolve() for given in options.paths], options.only)
    if not wanted:
        parser.error(f"no generated file and no pinned row of the corpus has {options.only!r} in its name")
    for path in regenerated(wanted):
        print(path.relative_to(ROOT))
    return 0


def chosen(folders: Sequence[Path], only: str) -> Mapping[Path, Callable[[], str]]:
    """Return the files below these folders that `only` names; if it names none, the file of losses with the rows that it names anew."""
    below = {path: content for path, content in GENERATED.items() if any(path.is_relative_to(each) for each in folders)}
    if named := {path: content for path, content in below.items() if only in path.name}:
        return named
    return {losses.FILE: partial(losses.all_losses, only)} if losses.of_rows(only) else {}


def regenerated(wanted: Mapping[Path, Callable[[], str]]) -> Iterator[Path]:
    """Write each of these files whose content has changed."""
    for path, content in wanted.items():
        print(f"{path.relative_to(ROOT)} ...", file=sys.stderr)
        text = content()
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            yield path


if __name__ == "__main__":
    sys.exit(main())
