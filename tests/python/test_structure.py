"""The files of the package: none imports another in a circle, and none reads the words of the program."""

from __future__ import annotations

import ast
import graphlib
from pathlib import Path

import pytest

import stickslip

PACKAGE = Path(stickslip.__file__).parent


def imported(text: str) -> set[str]:
    """The files of the package that a file imports, anywhere in it: in functions and for types alone, too."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and (node.level == 1 or (node.module or "").startswith("stickslip")):
            module = (node.module or "").removeprefix("stickslip").removeprefix(".")
            found |= {module} if module else {alias.name for alias in node.names}
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names if alias.name.startswith("stickslip.")]
            found |= {name.removeprefix("stickslip.") for name in names}
    return found


def order(files: dict[str, str]) -> list[str]:
    """The files in an order in which each imports only those before it."""
    return list(graphlib.TopologicalSorter({name: imported(text) for name, text in files.items()}).static_order())


def test_no_file_imports_another_in_a_circle() -> None:
    files = {file.stem: file.read_text(encoding="utf-8") for file in PACKAGE.glob("*.py")}
    found = order(files)
    assert len(files) > 10 and set(found) == set(files)
    assert found.index("_errors") < found.index("_process") < found.index("_run") < found.index("__init__")


@pytest.mark.parametrize("back", ["from ._b import y", "def f():\n    from stickslip._b import y", "from . import _b"])
def test_a_circle_is_found(back: str) -> None:
    with pytest.raises(graphlib.CycleError):
        order({"_a": f"if TYPE_CHECKING:\n    {back}\n" if "def" not in back else back, "_b": "import stickslip._a"})


def test_no_file_matches_text_or_makes_a_terminal() -> None:
    modules = {
        name
        # What shows messages in the terms of Python decides nothing by them.
        for file in set(PACKAGE.glob("*.py")) - {PACKAGE / "_words.py"}
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        )
    }
    assert "subprocess" in modules
    assert not modules & {"re", "pty", "termios", "tty"}
