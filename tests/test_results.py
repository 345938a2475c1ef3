from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import grader
from grader.engine.findings import Where
from grader.engine.results import ExtensionResult, Result, from_dict, to_dict, to_json
from grader.sandbox.isolation_levels import LEVELS
from tests.fake_results import check, lost, result

SCHEMA = json.loads((Path(grader.__file__).parent / "engine" / "result.schema.json").read_text(encoding="utf-8"))
VALID = jsonschema.Draft202012Validator(SCHEMA)

EVERY_OUTCOME = (
    check(),
    check("partial", 3.0),
    lost(),
    *(check(outcome, 0.0) for outcome in ("error", "timeout", "crashed", "skipped")),  # type: ignore[arg-type]
)
RESULTS = [
    result(*EVERY_OUTCOME),
    result(check("not_judged", None), status="incomplete"),
    result(lost(), status="empty", notes=("nothing",)),
    result(lost(), status="unreadable"),
    Result("nothing", "graded", ()),
]


def test_the_schema_knows_every_level() -> None:
    named = SCHEMA["$defs"]["provenance"]["properties"]["isolation"]["enum"]
    assert named == [isolation_level.name for isolation_level in LEVELS]


def test_what_a_check_found_is_written_in_fields_and_as_one_text_and_read_back() -> None:
    found = check(
        "error", 0.0, expected="no exception", got="ValueError: no\nraise", where=Where("lab.py", 3), keeps=0.0
    )
    record = to_dict(result(found))
    VALID.validate(record)
    row = record["criteria"][0]["checks"][0]
    assert row["message"] == "Expected  no exception\nGot       ValueError: no\n          raise"
    assert row["where"] == {"file": "lab.py", "line": 3}
    assert from_dict(record).criteria[0].checks == (found,)


def test_a_record_from_before_there_were_fields_keeps_its_message() -> None:
    record = to_dict(result(check("failed", 0.0, expected="a", got="b")))
    row = record["criteria"][0]["checks"][0]
    for name in ("expected", "got", "where"):
        del row[name]
    VALID.validate(record)
    assert from_dict(record).criteria[0].checks[0].message == "Expected  a\nGot       b"


def test_what_is_written_obeys_the_published_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    for made in RESULTS:
        VALID.validate(json.loads(to_json(made)))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("surprise",), 1),
        (("schema",), "imugrade/result/v2"),
        (("status",), "fine"),
        (("score",), "87"),
        (("score",), -1),
        (("misconceptions",), ["Not An Id"]),
        (("provenance", "secret"), "x"),
        (("provenance", "rubric_sha256"), "abc"),
        (("criteria", 0, "surprise"), 1),
        (("criteria", 0, "checks", 0, "surprise"), 1),
        (("criteria", 0, "checks", 0, "outcome"), "won"),
        (("criteria", 0, "checks", 0, "points"), None),
        (("criteria", 0, "checks", 0, "outcome"), "not_judged"),
        (("criteria", 0, "checks", 0, "lab_step"), 7),
        (("extensions", 0, "title"), "no title here"),
    ],
)
def test_the_schema_refuses_what_the_contract_does_not_name(path: tuple[str | int, ...], value: object) -> None:
    record = to_dict(result(*EVERY_OUTCOME))
    place: Any = record
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    assert not VALID.is_valid(record)


def test_the_schema_asks_for_every_field_and_refuses_an_open_check_in_a_graded_result() -> None:
    record = to_dict(result())
    for field in record.keys() - {"lab"}:  # results of before have none
        assert not VALID.is_valid({name: value for name, value in record.items() if name != field}), field
    incomplete = to_dict(result(check("not_judged", None), status="incomplete"))
    assert not VALID.is_valid({**incomplete, "status": "graded"})


def test_students_do_not_see_where_the_grader_failed_on_hidden_scenarios() -> None:
    """Code could choose the line."""
    open_, extension = result(check(fault="a line")), ExtensionResult("x", True, 0.0, (check(fault="a line"),))
    made = replace(open_, extensions=(extension,))
    assert to_json(made).count("a line") == 2
    assert "a line" not in to_json(replace(made, provenance={**made.provenance, "hidden": True}))


def test_hostile_text_is_written_as_text_that_every_reader_takes() -> None:
    text = to_json(result(name="\ud800\x00\x1b[2J", notes=("\u202e",)))
    assert json.loads(text.encode("utf-8"))["submission"] == "?\x00\x1b[2J"


def test_another_schema_is_not_read() -> None:
    with pytest.raises(ValueError, match="not an imugrade/result/v1 record: schema is 'v0'"):
        from_dict({"schema": "v0"})
