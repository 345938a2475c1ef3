"""Sphinx configuration. `bash docs/build OUT` builds the site."""

from __future__ import annotations

import os
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
smartquotes = False  # headings are messages: --format keeps its two hyphens

# "Edit this page" needs the address of the repository, which only the machine that publishes the site knows.
_hosted = os.environ.get("READTHEDOCS_GIT_CLONE_URL", "").removesuffix(".git")
if not _hosted and "GITHUB_REPOSITORY" in os.environ:
    _hosted = f"{os.environ.get('GITHUB_SERVER_URL', 'https://github.com')}/{os.environ['GITHUB_REPOSITORY']}"
if _hosted:
    html_theme_options = {"source_repository": _hosted, "source_branch": "main", "source_directory": "docs/"}


def setup(app: Sphinx) -> None:
    """Make the navigation of the site from the lists of links on the index pages, which a repository's web page shows, too.

    Links to the repository's own pages, such as SECURITY.md, lead to the pages of the site that include them.
    """

    def read(_app: Sphinx, page: str, text: list[str]) -> None:
        text[0] = re.sub(r"\((?:\.\./)+([A-Z]+)\.md", lambda link: f"(/{link[1].lower()}.md", text[0])
        listed = re.findall(r"^- \[[^]]+\]\((\w+/index|/?[\w-]+)\.md\)", text[0], re.MULTILINE)
        if page.rpartition("/")[2] == "index" and listed:
            text[0] += "\n```{toctree}\n:hidden:\n" + "\n".join(listed) + "\n```\n"

    app.connect("source-read", read)
