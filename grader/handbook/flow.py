"""The picture of the way of a submission, as SVG that follows the reader's light or dark."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

WIDTH, HEIGHT = 960, 440
_STYLE = """
    text { font: 15px system-ui, sans-serif; fill: #1c2430 }
    .small { font-size: 12.5px; fill: #566070 }
    rect { fill: #f3f5f8; stroke: #8a94a6 }
    .walled { fill: #fdf3e3; stroke: #b7791f; stroke-dasharray: 6 4 }
    .made { fill: #e7f1ea; stroke: #3d7a52 }
    path { fill: none; stroke: #566070; stroke-width: 1.5 }
    marker path { fill: #566070; stroke: none }
    @media (prefers-color-scheme: dark) {
      text { fill: #e6eaf0 } .small { fill: #a5afbf } rect { fill: #222936; stroke: #6b7688 }
      .walled { fill: #33290f; stroke: #d69e2e } .made { fill: #16301f; stroke: #5fa579 }
      path { stroke: #a5afbf } marker path { fill: #a5afbf }
    }
"""


@dataclass(frozen=True)
class Box:
    """A station: its place, its name, what it does, and its kind (``walled`` runs students' code)."""

    x: int
    y: int
    name: str
    tells: str
    kind: str = ""
    width: int = 190


_BOXES = {
    "handed": Box(20, 30, "handed in", "folder, zip, LMS download", "made"),
    "intake": Box(260, 30, "intake", "bytes, bounded, no links"),
    "box": Box(500, 30, "sandbox", "student's process, walled", "walled"),
    "answers": Box(740, 30, "answers", "plain arrays, figure facts", "made", 200),
    "reference": Box(20, 190, "reference", "solution and scenarios"),
    "traces": Box(260, 190, "traces", "true arrays, a manifest", "made"),
    "checks": Box(500, 190, "checks", "pytest: compare, judge"),
    "diagnosis": Box(740, 190, "diagnosis, feedback", "mistakes that fit, words", "", 200),
    "rubric": Box(20, 340, "rubric.yaml", "points and limits", "made"),
    "result": Box(260, 340, "result.json", "stored as it arrives", "made"),
    "told": Box(500, 340, "told", "terminal, report.html, class index, gradebooks, CI formats", "", 440),
}
_ARROWS = (
    "M210 62 H254", "M450 62 H494", "M690 62 H734",
    "M840 94 V140 H595 V184",
    "M210 222 H254", "M450 222 H494", "M690 222 H734",
    "M840 254 V296 H380 V334",
    "M210 372 H254", "M450 372 H494",
)  # fmt: skip


def picture() -> str:
    """The SVG's text."""
    boxes = "\n".join(_drawn(box) for box in _BOXES.values())
    arrows = "\n".join(f'  <path d="{path}" marker-end="url(#tip)"/>' for path in _ARROWS)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-labelledby="t">\n'
        '  <title id="t">From what was handed in, through the sandbox and the checks, to the result</title>\n'
        f"  <style>{_STYLE}  </style>\n"
        '  <defs><marker id="tip" viewBox="0 0 8 8" refX="6" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
        '<path d="M0 0 L8 4 L0 8 z"/></marker></defs>\n'
        f"{arrows}\n{boxes}\n</svg>\n"
    )


def _drawn(box: Box) -> str:
    kind = f' class="{box.kind}"' if box.kind else ""
    return (
        f'  <rect{kind} x="{box.x}" y="{box.y}" width="{box.width}" height="64" rx="6"/>\n'
        f'  <text x="{box.x + 14}" y="{box.y + 27}">{escape(box.name)}</text>\n'
        f'  <text class="small" x="{box.x + 14}" y="{box.y + 47}">{escape(box.tells)}</text>'
    )
