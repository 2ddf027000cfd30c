"""Figures and reports that the program wrote, as a notebook shows them."""

from __future__ import annotations

import base64
import html
import os
from pathlib import Path
from typing import Any
from urllib.parse import quote


class Plot:
    """A figure.

    Attributes
    ----------
    svg, png, pdf : pathlib.Path or None
        Its files.
    """

    def __init__(self, svg: Path | None, png: Path | None, pdf: Path | None) -> None:
        self.svg = svg
        self.png = png
        self.pdf = pdf
        # A temporary folder stays as long as something is in use that lies in it.
        self._source: object = None

    @classmethod
    def _of(cls, files: list[Path]) -> Plot:
        by_ending = {file.suffix.lower(): file for file in files}
        return cls(by_ending.get(".svg"), by_ending.get(".png"), by_ending.get(".pdf"))

    def __repr__(self) -> str:
        return f"stickslip.Plot({', '.join(str(file) for file in (self.svg, self.png, self.pdf) if file)})"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        bundle = {"text/plain": repr(self)}
        if self.svg is not None:
            bundle["image/svg+xml"] = self.svg.read_text(encoding="utf-8")
        elif self.png is not None:
            bundle["image/png"] = base64.b64encode(self.png.read_bytes()).decode()
        return bundle


class Report:
    """A report. It is a path for ``open`` and others (``os.PathLike``).

    Attributes
    ----------
    path : pathlib.Path
        The HTML file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def __fspath__(self) -> str:
        return str(self.path)

    def __repr__(self) -> str:
        return f"stickslip.Report({str(self.path)!r})"

    def _repr_html_(self) -> str:
        # A notebook opens files below its folder alone.
        relative = os.path.relpath(self.path)
        target = self.path.as_uri() if relative.startswith("..") else quote(relative)
        return f'<a href="{html.escape(target)}" target="_blank">{html.escape(relative)}</a>'


def written(output: str) -> list[Path]:
    """The files that the program says it wrote, one on each line."""
    return [Path(os.path.abspath(_path(line))) for line in output.split("\n") if line]


def _path(line: str) -> str:
    """A path, which stands as a shell takes it, ``$'...'``, where it holds what is not seen."""
    if not line.startswith("$'"):
        return line
    return os.fsdecode(line[2:-1].encode().decode("unicode_escape").encode("latin-1"))
