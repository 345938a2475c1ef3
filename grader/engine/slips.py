"""A name for which a submission's function raised, and what was taken for it: noticed in one process, mended in the next one."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from grader.engine.findings import Fault
from grader.sandbox.wire import Frame


@dataclass(frozen=True)
class Slip:
    """As `harness.slips` notices it; nothing of it is believed but that the student's own text holds such names.

    Attributes
    ----------
    path, function, at : the file, and the lines in it where the function begins and where the name stands
    kind : what is mended: an ``expression``, a ``keyword``, a variable of ``__init__`` that is not ``kept``, a base that is not
        ``begun``, a missing ``self``;
        of what is no name an ``index``, a ``whole`` number, a ``shape``, ``numbers`` of a list, what was ``appended`` or
        ``called``, the ``arguments`` of a call, a ``statement``, what is never ``made``, what is ``moved``, a helper's value that
        is ``returned``, an array that is ``asked`` whether it is true, or ``compared`` with nothing; a call whose value nobody
        uses, or what is asserted, is ``left out``
    own, meant : what is written there, and what was taken for it; of what is left out what it raised
    """

    path: str
    function: int
    at: int
    kind: str
    own: str
    meant: str

    @property
    def is_left_out(self) -> bool:
        return self.kind == "left out"

    @property
    def mistake(self) -> str:
        """What the catalogue calls it."""
        if self.kind in ("asked", "compared"):
            return "array-asked-for-truth"
        if self.is_left_out and self.meant.startswith("ModuleNotFoundError"):
            return "missing-package"
        if self.kind == "returned":
            return "return-missing"
        return "unknown-name" if self.kind in ("expression", "keyword", "kept", "self") else "raises"

    @property
    def fault(self) -> Fault:
        """The place, as that of what was raised."""
        return Fault("", "", self.path, self.at, None, None)

    @classmethod
    def of(cls, frame: Frame) -> Slip | None:
        fields = frame.fields.get("slip")
        return None if fields is None else cls(**{name: fields[name] for name in cls.__annotations__})

    def fields(self) -> dict[str, Any]:
        """What the harness is given."""
        return asdict(self)
