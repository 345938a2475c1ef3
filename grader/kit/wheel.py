"""Make the students' wheel, which installs `imugrade` without `reference`, the package with the solution.

It is made from the running `grader`, installed by pip (from a checkout, too, with `pip install -e`). That needs no build tool: a
wheel is a zip archive with three files of its own (packaging.python.org, *Binary distribution format*).
"""

from __future__ import annotations

import base64
import hashlib
import importlib.metadata
import io
import json
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath

import yaml

from grader import __version__
from grader.base import class_versions
from grader.base.errors import RequestError
from grader.base.package_data import beside
from grader.engine.lab import Lab, LabFile
from grader.engine.rubric import CARRIED, own_checks
from grader.kit import guide
from grader.report import truth

_KINDS = (".py", ".txt", ".ini", ".yaml", ".json", ".npz", ".xml", ".j2", ".css", ".js", ".md", ".svg", ".typed")
_BUNDLES = (".npz", ".json")
# Any other bundle in the lab's folder would be an instructor's own.
_PUBLIC = ("public.npz", "public.json", "result.schema.json")
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the same bytes whenever it is made


def name() -> str:
    """Return the file name of the wheel that students and CI jobs install: ``imugrade-0.1.0-py3-none-any.whl``."""
    return f"imugrade-{__version__}-py3-none-any.whl"


def build(lab: Lab, rubric: Path, own: LabFile | None = None) -> bytes:
    """Return the bytes of the wheel that students and CI jobs install: `grader`, which lacks the solution, with this rubric.

    Parameters
    ----------
    rubric : the rubric's file, beside which the instructor's own checks lie; the wheel contains both
    own : the instructor's file, such as a robot model, that the rubric names in place of the lab's; the wheel contains it, and the
        traces recorded with it in place of the lab's public ones; None if the rubric names none

    Raises
    ------
    RequestError
        If this package is not installed, so that its requirements are not known.
    """
    info = f"imugrade-{__version__}.dist-info"
    place = f"grader/{lab.folder.relative_to(beside('grader', '')).as_posix()}"
    files = {**dict(_package()), f"{place}/rubric.yaml": rubric.read_bytes()}
    files[f"{place}/{class_versions.FILE}"] = class_versions.constraints(lab.packages).encode()
    files |= {f"{place}/{CARRIED}/{name}": content for name, content in own_checks(lab, rubric.parent)}
    files |= {f"{place}/guide/{page.name}": page.read_bytes() for page in sorted(guide.pages(lab).iterdir())}
    files |= _own(place, rubric, own) if own else {}
    files |= {f"{info}/{path}": text.encode() for path, text in _information().items()}
    record = "".join(f"{path},{_digest(content)},{len(content)}\n" for path, content in files.items())
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    return pack(files)


def pack(files: Mapping[str, bytes], programs: tuple[str, ...] = ()) -> bytes:
    """Return a zip archive of these files, with the same bytes whenever it is made; those in `programs` are executable."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            entry = zipfile.ZipInfo(path, _EPOCH)
            entry.external_attr = (0o100755 if path in programs else 0o100644) << 16
            entry.create_system = 3  # Unix, or the modes above mean nothing
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return stream.getvalue()


def _package() -> Iterator[tuple[str, bytes]]:
    """Yield path and bytes of the package's files that students get: without the rubric and an instructor's own traces."""
    package = beside("grader", "")
    for path in sorted(package.rglob("*")):
        inside = path.relative_to(package)
        if path.is_file() and _belongs(inside):
            yield f"grader/{inside.as_posix()}", path.read_bytes()


def _own(folder: str, rubric: Path, own: LabFile) -> dict[str, bytes]:
    """Return the files for an instructor's own robot: it, its public traces, and the rubric with the robot's path in the wheel."""
    text, place = rubric.read_text(encoding="utf-8-sig"), f"own/{own.file}"
    files = {f"{folder}/public{suffix}": content for suffix, content in truth.files(own.traces).items()}
    path = _named_in(text, own.keys)
    if path is not None:
        start, end = path.start_mark.index, path.end_mark.index
        text = f"{text[:start]}{json.dumps(place)}{text[end:]}"
        files[f"{folder}/{place}"] = own.text.encode()
    return {**files, f"{folder}/rubric.yaml": text.encode()}


def _named_in(rubric: str, keys: Iterable[str]) -> yaml.Node | None:
    """Return the value at these nested keys of a valid rubric's text, with its place there, to replace it; None if left out."""
    node: yaml.Node | None = yaml.compose(rubric, Loader=yaml.SafeLoader)
    for name in keys:
        pairs = node.value if node else []
        node = next((value for key, value in pairs if key.value == name), None)
    return node


def _belongs(inside: Path) -> bool:
    if any(part.startswith((".", "__pycache__")) for part in inside.parts) or inside.suffix not in _KINDS:
        return False
    if inside.name == "rubric.yaml":
        return False
    return inside.suffix not in _BUNDLES or inside.name in _PUBLIC


def _information() -> dict[str, str]:
    """Return the metadata files of the wheel, made from the installed package's; raise RequestError if it is not installed."""
    try:
        installed = importlib.metadata.distribution("imugrade")
    except importlib.metadata.PackageNotFoundError:
        raise RequestError(
            "imugrade is not installed here, so its requirements are not known; pip install it"
        ) from None
    about = installed.metadata
    lines = ["Metadata-Version: 2.1", "Name: imugrade", f"Version: {__version__}", f"Summary: {about['Summary']}"]
    lines += [f"Requires-Python: {about['Requires-Python']}"]
    lines += [f"Requires-Dist: {need}" for need in installed.requires or () if "extra ==" not in need]
    files = {
        "METADATA": "\n".join([*lines, ""]),
        "WHEEL": "Wheel-Version: 1.0\nGenerator: imugrade kit\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        "entry_points.txt": _entry_points(installed),
    }
    licence = next((f for f in installed.files or () if PurePosixPath(f).name == "LICENSE"), None)
    return files | ({"licenses/LICENSE": licence.read_text()} if licence else {})


def _entry_points(installed: importlib.metadata.Distribution) -> str:
    """Return the text of `entry_points.txt`, by which pip installs the command and pytest finds the plugin."""
    groups: dict[str, list[str]] = {}
    for entry in installed.entry_points:
        groups.setdefault(entry.group, []).append(f"{entry.name} = {entry.value}\n")
    return "".join(f"[{group}]\n{''.join(lines)}" for group, lines in groups.items())


def _digest(content: bytes) -> str:
    """Return the digest of a file as a wheel's RECORD lists it: urlsafe base64 without padding."""
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
