"""Types of the values in a reply of the sandbox, each with its limit, so that student code cannot send too much."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from msgspec import Meta

Short: TypeAlias = Annotated[str, Meta(max_length=200)]
Long: TypeAlias = Annotated[str, Meta(max_length=2000)]
Whole: TypeAlias = Annotated[int, Meta(ge=-1_000_000_000, le=1_000_000_000)]
Number: TypeAlias = Annotated[float, Meta(ge=-1e12, le=1e12)]
Names: TypeAlias = Annotated[tuple[Short, ...], Meta(max_length=64)]
Pair: TypeAlias = tuple[Number, Number]
