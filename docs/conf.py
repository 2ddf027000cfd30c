"""The documentation site, which `make docs` builds: README.md, the pages of SUMMARY.md and the files to which they link.

Sphinx with MyST reads the same Markdown as a view of the repository does. A link that leads nowhere is an error.
"""

import re
from pathlib import Path
from typing import Iterator

from sphinx.application import Sphinx

project = html_title = "stickslip"

extensions = ["myst_parser"]
# The root is the repository, where only pages are read.
root_doc = "README"
include_patterns = ["*.md", "docs/**.md"]
exclude_patterns = [".*", "crates", "jobs", "target", "tests", "docs/SUMMARY.md"]
# Headings to which pages may link.
myst_heading_anchors = 4
# What a terminal shows is not always a session that a highlighter can read.
suppress_warnings = ["misc.highlighting_failure"]
smartquotes = False

html_theme = "furo"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_copy_source = html_show_sphinx = False


def contents() -> Iterator[str]:
    """The contents at the side of each page: a `toctree` for each heading of SUMMARY.md with its pages below it."""
    summary = Path(__file__).with_name("SUMMARY.md").read_text(encoding="utf-8")
    for part in re.split("^# ", summary, flags=re.MULTILINE)[2:]:
        heading, pages = part.split("\n", 1)
        yield f"\n```{{toctree}}\n:hidden:\n:caption: {heading}\n"
        for title, page in re.findall(r"^- \[(.+)\]\((.+)\.md\)$", pages, flags=re.MULTILINE):
            yield f"{title} </{f'docs/{page}'.removeprefix('docs/../')}>"
        yield "```\n"


def add_contents(_: Sphinx, page: str, text: list[str]) -> None:
    if page == root_doc:
        text[0] += "\n".join(contents())


def setup(app: Sphinx) -> None:
    app.connect("source-read", add_contents)
