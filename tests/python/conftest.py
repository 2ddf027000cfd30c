"""What the tests of the Python package share. They run against the wheel that is installed, not against python/."""

from __future__ import annotations

import copy
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import stickslip

#: Seconds in which only what hangs does not come.
PATIENCE = 3600

REPOSITORY = Path(__file__).resolve().parents[2]

#: A job that takes a hundredth of a second: 3 rotating speeds, 2 preloads, 4 friction coefficients.
SMALL: dict[str, Any] = {
    "name": "small",
    "axes": {
        "rotating_speed": [10.0, 15.0, 20.0],
        "preload": [0.1, 0.2],
        "static_friction": {"from": 0.3, "to": 0.45, "points": 4},
    },
    "random": {"inputs": ["preload", "static_friction"], "relative_std": {"preload": 0.2, "static_friction": 0.1}},
    "criterion": {"kind": "eigenvalue"},
    "sampling": {"samples": 1000, "seed": 7},
}

#: A job that takes many seconds on one thread.
LONG: dict[str, Any] = {
    "name": "long",
    "axes": {"preload": {"from": 0.05, "to": 0.15, "points": 5}, "static_friction": 0.39},
    "random": {"inputs": ["preload", "static_friction"], "relative_std": 0.2},
    "criterion": {"kind": "time-domain"},
    "sampling": {"samples": 50_000, "seed": 3},
}


def pytest_configure() -> None:
    """These tests are of the wheel alone, and send SIGINT, which a shell lets its background jobs ignore."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    assert "STICKSLIP_PROGRAM" not in os.environ, "unset STICKSLIP_PROGRAM"
    assert REPOSITORY / "python" not in Path(stickslip.__file__).parents, "install the wheel: make test-python"


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory of its own for each test, with a name that is not plain."""
    folder = tmp_path / "Bremsen und Geräusche 制动"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def small() -> dict[str, Any]:
    return copy.deepcopy(SMALL)


@pytest.fixture
def stub(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Puts a program in place of stickslip: the text of a Python script."""

    def put(script: str) -> Path:
        path = tmp_path / "stub"
        path.write_text(f"#!{sys.executable}\n{script}", encoding="utf-8")
        path.chmod(0o755)
        monkeypatch.setenv("STICKSLIP_PROGRAM", str(path))
        return path

    return put


def python(script: str, *, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Runs a script with the interpreter of the tests."""
    return subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE,
    )
