"""Sphinx configuration. `bash docs/build OUT` builds the site."""

from __future__ import annotations

import re
from importlib.metadata import version as installed

from sphinx.application import Sphinx

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
    """Make the navigation of the site from the lists of links on the index pages, which a repository's web page shows, too."""

    def read(_app: Sphinx, page: str, text: list[str]) -> None:
        if page.rpartition("/")[2] == "index" and (
            listed := re.findall(r"^- \[[^]]+\]\((\S+)\.md\)", text[0], re.MULTILINE)
        ):
            text[0] += "\n```{toctree}\n:hidden:\n" + "\n".join(listed) + "\n```\n"

    app.connect("source-read", read)
