"""Short fuzzing of everything that reads what strangers wrote; the long runs are made by hand."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from grader.base.errors import RequestError
from grader.engine import rubric
from grader.labs.imu.lab import LAB
from grader.worker import notebooks
from tests.corpus.writing import notebook
from tests.fuzz.answers import Bench, everything
from tests.fuzz.decoder import FRAME, check_decoder, framed
from tests.fuzz.mangling import mangled_bytes

SHORT = settings(max_examples=200, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
SEEDS = st.integers(0, 2**32 - 1)


@settings(SHORT, max_examples=400)
@given(st.binary(max_size=300) | SEEDS.map(lambda seed: mangled_bytes(FRAME, random.Random(seed))))
@example(b"")
@example(FRAME)
def test_the_decoder_takes_any_bytes_and_frames_that_are_almost_right(data: bytes) -> None:
    check_decoder(data)
    check_decoder(framed(data))


# --- the rubric ----------------------------------------------------------------------------------------------------------

RUBRIC = rubric.shipped(LAB).read_bytes()


@settings(SHORT, max_examples=600)
@given(
    SEEDS.map(lambda seed: mangled_bytes(RUBRIC, random.Random(seed)))
    | st.binary(max_size=200)
    | st.text(max_size=200).map(lambda text: text.encode("utf-8", "replace"))
)
@example(b"a: &a [*a, *a]\n")
@example(b"[" * 5000)
@example(b"criteria: !!python/object/apply:os.system ['true']\n")
def test_a_rubric_of_any_bytes_is_taken_or_refused_in_lines_that_name_it(text: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rubric.yaml"
        path.write_bytes(text)
        told = ""
        try:
            rubric.load(LAB, path)
        except RequestError as refusal:
            told = str(refusal)
        assert all("rubric.yaml" in line and line.isprintable() for line in told.split("\n") if told)


# --- notebooks -----------------------------------------------------------------------------------------------------------

MAGIC_LINES = (
    "%timeit -n 3 f()", "!pip install \\", "    it's", "if x:", "    %run a.py", "x = (1", "  % 2)", "y?", "z = !ls", "%time ", "",
)  # fmt: skip


@SHORT
@given(st.lists(st.sampled_from(MAGIC_LINES), max_size=12))
def test_a_cell_without_its_magics_has_as_many_lines(lines: list[str]) -> None:
    assert len(notebooks.plain_python("\n".join(lines)).split("\n")) == max(len(lines), 1)


@pytest.mark.parametrize(
    "path",
    ["../a.py", "/etc/a.py", "a/../../b.py", ".ssh/a.py", "'a.py", "~/a.py", "C:/a.py", "a.pth"],
)
def test_a_cell_writes_no_file_outside_its_folder(path: str) -> None:
    assert notebooks.files_written(notebook(f"%%writefile {path}\nx = 1").encode()) == {}


@SHORT
@given(st.binary(max_size=300))
@example(b"[" * 100_000)
@example(b'{"cells": [{"cell_type": "code", "source": {"a": 1}}]}')
def test_a_notebook_of_any_bytes_gives_cells_or_a_value_error(content: bytes) -> None:
    try:
        notebooks.code_cells(content)
    except (ValueError, RecursionError):
        return


# --- answers of the sandbox --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    with Bench(everything()).open() as bench:
        yield bench


@settings(SHORT, max_examples=20)
@given(seed=SEEDS)
def test_no_answer_of_the_box_leaves_a_check_without_a_verdict(bench: Bench, seed: int) -> None:
    result = bench.mark(seed)
    assert bench.troubles == []
    assert result.status == "graded"
    assert 0 <= result.score <= result.max_score
