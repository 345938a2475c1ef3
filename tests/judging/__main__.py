"""Write the words of all findings of the made-up students anew: `python -m tests.judging`."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import yaml

from tests.judging.made import WORDS, finding, words


def main() -> int:
    names = sorted(path.stem for path in Path(__file__).parent.glob("test_check_*.py"))
    cases = [case for name in names for case in importlib.import_module(f"tests.judging.{name}").CASES]
    said = {case.id: told for case in cases if (told := words(finding(case)))}
    WORDS.write_text(yaml.safe_dump(said, sort_keys=True, width=200, allow_unicode=True), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
