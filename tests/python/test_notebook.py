"""The tutorial docs/first-surface.ipynb: it runs, its stored outputs are true, and its numbers are right."""

from __future__ import annotations

import math
import re
from pathlib import Path

import nbclient
import nbformat
import numpy as np
import pytest
from conftest import PATIENCE, REPOSITORY

# How long a notebook waits for its kernel, for a cell, and for what the cell prints.
PATIENT = {"startup_timeout": PATIENCE, "timeout": PATIENCE, "iopub_timeout": PATIENCE}

STORED = REPOSITORY / "docs" / "first-surface.ipynb"

# The preset (docs/reference/job-spec.md): friction, tangential damping, stiffness, the radius at which the pad slides.
STATIC, KINETIC, STRIBECK = 0.39, 0.25, 0.72
DAMPING = 369.0
FORCE_PER_PRELOAD = 0.02 * 3.816e7 * 3.249e7 / (3.816e7 + 3.249e7)
RADIUS = 0.135


@pytest.fixture(scope="module")
def outputs(tmp_path_factory: pytest.TempPathFactory) -> list[nbformat.NotebookNode]:
    """The outputs of the notebook, run now."""
    notebook = nbformat.read(STORED, as_version=4)
    folder = tmp_path_factory.mktemp("notebook")
    nbclient.NotebookClient(notebook, **PATIENT, resources={"metadata": {"path": str(folder)}}).execute()
    assert (folder / "runs" / "first-surface" / "surface.parquet").is_file()
    return [output for cell in notebook.cells for output in cell.get("outputs", [])]


def texts(outputs: list[nbformat.NotebookNode]) -> list[str]:
    """What the outputs say. A kernel sends what is printed in pieces of any length: pieces that follow are one text."""
    texts: list[str] = []
    previous = None
    for output in outputs:
        stream = output.get("name")
        if stream is not None and stream == previous:
            texts[-1] += output["text"]
        else:
            texts.append(output["text"] if stream else output["data"]["text/plain"])
        previous = stream
    return texts


def test_the_stored_outputs_are_those_of_now(outputs: list[nbformat.NotebookNode]) -> None:
    stored = nbformat.read(STORED, as_version=4)
    nbformat.validate(stored)
    kept = [output for cell in stored.cells for output in cell.get("outputs", [])]
    assert texts(kept) == texts(outputs)
    assert not [output for output in outputs if output.get("name") == "stderr"]
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == 2 and all(len(picture["data"]["image/png"]) > 10_000 for picture in pictures)


def is_unstable(speed: float, preload: np.ndarray, static: np.ndarray) -> np.ndarray:
    """Whether friction feeds more into the pad than its damper takes out (docs/theory.md), by NumPy alone."""
    slope = (static - KINETIC) / STRIBECK * math.exp(-speed * RADIUS / STRIBECK)
    return FORCE_PER_PRELOAD * preload * slope > DAMPING


def share(speed: float, preload: float, static: float) -> float:
    """The probability of instability of a cell by a million samples of another generator."""
    generator = np.random.default_rng(12)
    deviates = generator.standard_normal((2, 1_000_000))
    samples = preload * (1 + 0.2 * deviates[0]), static * (1 + 0.1 * deviates[1])
    return float(is_unstable(speed, *samples).mean())


def test_its_numbers_are_those_of_other_means(outputs: list[nbformat.NotebookNode]) -> None:
    text = "\n".join(texts(outputs))
    critical = float(re.search(r"critical speed ([0-9.]+) rad/s", text)[1])  # type: ignore[index]
    force = FORCE_PER_PRELOAD * 0.1
    closed_form = STRIBECK / RADIUS * math.log(force * (STATIC - KINETIC) / (STRIBECK * DAMPING))
    assert critical == pytest.approx(closed_form, abs=1e-4)

    p, low, high = map(float, re.search(r"([0-9.]+), between ([0-9.]+) and ([0-9.]+)", text).groups())  # type: ignore[union-attr]
    assert p == pytest.approx(share(15.0, 0.1, 0.39), abs=0.015)
    assert low < share(15.0, 0.1, 0.39) < high

    rows = re.findall(r"^\d +([0-9.]+) +([0-9.]+) +([0-9.]+)$", text, re.MULTILINE)
    assert len(rows) == 6
    for speed, target, preload in rows:
        assert share(float(speed), float(preload), 0.39) == pytest.approx(float(target), rel=0.03)


def test_it_links_to_pages_that_exist() -> None:
    notebook = nbformat.read(STORED, as_version=4)
    links = re.findall(r"\]\(([^)]+)\)", "\n".join(cell.source for cell in notebook.cells))
    assert len(links) >= 3
    assert all((STORED.parent / Path(link)).is_file() for link in links)


def test_progress_is_a_bar_in_a_notebook(tmp_path: Path) -> None:
    cell = """
import stickslip
job = {
    "name": "bar",
    "axes": {"preload": {"from": 0.05, "to": 0.15, "points": 5}, "static_friction": 0.39},
    "random": {"inputs": ["preload", "static_friction"], "relative_std": 0.2},
    "criterion": {"kind": "time-domain"},
    "sampling": {"samples": 50_000, "seed": 3},
}
import re
import IPython.display
shown, kept = [], IPython.display.DisplayHandle.update
def update(self, bundle, **options):
    shown.append(bundle["text/html"])
    kept(self, bundle, **options)
IPython.display.DisplayHandle.update = update
stickslip.run(job, threads=1)
*bars, last = shown
assert bars and last == "", shown
bar = re.compile(r'<progress max="1" value="(0\\.\\d{4}|1\\.0000)"></progress> .*samples/s')
assert all(bar.match(text) for text in bars), shown
"""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell)])
    nbclient.NotebookClient(notebook, **PATIENT, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = notebook.cells[0]["outputs"]
    assert "%" not in "".join(output["text"] for output in outputs if output.get("name") == "stderr")
