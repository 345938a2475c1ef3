"""What each folder of `submissions_example/` must get: `python -m tests.examples` writes its `expected.json` anew.

Look at the difference before it is committed: a mark that moved is a promise that was broken, or one that is now kept.
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

from grader.engine import rubric
from grader.engine.marking import Marker
from grader.engine.results import Result
from grader.intake import read_submission
from grader.labs.imu import bundles
from grader.labs.imu.lab import LAB

FOLDER = Path(__file__).resolve().parent.parent / "submissions_example"


def folders() -> list[Path]:
    return sorted(path for path in FOLDER.iterdir() if path.is_dir())


def summary(result: Result) -> dict[str, Any]:
    """What does not depend on versions and machines: status, every outcome with its points, and the mistakes named."""
    checks = [check for criterion in result.criteria for check in criterion.checks]
    return {
        "status": result.status,
        "score": result.score,
        "criteria": {criterion.id: criterion.points for criterion in result.criteria},
        "checks": {check.id: [check.outcome, check.points] for check in checks},
        "misconceptions": list(result.misconceptions),
        "notes": list(result.notes),
        **_extensions(result),
    }


def _extensions(result: Result) -> dict[str, Any]:
    """The outcomes of the extensions that were handed in."""
    tried = {e.id: {check.id: check.outcome for check in e.checks} for e in result.extensions if e.attempted}
    return {"extensions": tried} if tried else {}


def main() -> None:
    argparse.ArgumentParser(prog="python -m tests.examples", description=__doc__).parse_args()
    with Marker(rubric.load(LAB), bundles.shipped(), rung=os.environ.get("IMUGRADE_RUNG")) as marker:
        for folder in folders():
            found = summary(marker.mark(read_submission(folder, LAB.files)))
            (folder / "expected.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
            print(folder.name, found["status"], found["score"], *found["misconceptions"])


if __name__ == "__main__":
    main()
