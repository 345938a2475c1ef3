"""Sphinx configuration. `bash docs/build OUT` builds the site."""

from __future__ import annotations

import sys
from importlib.metadata import version as installed
from pathlib import Path

from sphinx.application import Sphinx

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from docs import generated

project = "imugrade"
author = copyright = "the authors of imugrade"
release = version = installed("imugrade")
extensions = ["myst_parser"]
html_theme = "furo"
html_title = f"imugrade {release}"
html_show_sourcelink = html_copy_source = False
html_static_path = ["static"]
html_css_files = ["site.css"]
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]


def setup(app: Sphinx) -> None:
    """Fill the generated parts of each page when Sphinx reads it."""

    def read(_app: Sphinx, _page: str, text: list[str]) -> None:
        text[0] = generated.fill(text[0])

    app.connect("source-read", read)
