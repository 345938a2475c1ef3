"""What students write on axes and into legends is read in every language that has a block in `languages.yaml`."""

from __future__ import annotations

import pytest

from grader.labs.imu.visualization import labels

SAMPLES = [(code, text, kind) for code, block in labels.languages().items() for text, kind in block["labels"].items()]


@pytest.mark.quick
@pytest.mark.parametrize("code", labels.languages())
def test_a_language_has_three_axes_and_samples_of_every_unit(code: str) -> None:
    block = labels.languages()[code]
    assert len(block["axes"]) == 3
    assert {"m/s²", "rad/s", "s"} <= set(block["labels"].values())


@pytest.mark.quick
@pytest.mark.parametrize(("code", "text", "kind"), SAMPLES)
def test_a_label_is_read_as_what_it_says(code: str, text: str, kind: str) -> None:
    if kind == "samples":
        assert labels.counts_samples(text)
    elif kind in ("s", "ms"):
        assert labels.has_time_unit(text)
        assert labels.in_milliseconds(text) == (kind == "ms")
    else:
        assert labels.unit_of(text) == kind
        assert labels.claims(text) == {0 if kind == "m/s²" else 1}


@pytest.mark.quick
@pytest.mark.parametrize("code", labels.languages())
def test_the_words_for_axes_and_for_the_comparison_are_told_apart(code: str) -> None:
    block = labels.languages()[code]
    assert [labels.axis_of(word) for words in block["axes"] for word in words] == [
        axis for axis, words in enumerate(block["axes"]) for _ in words
    ]
    assert all(labels.says_raw(word) for word in block["raw"])
    assert all(labels.says_smooth(word) for word in block["filtered"])
