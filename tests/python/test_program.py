"""Which program the package calls, in every way in which it can be installed."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest
from conftest import REPOSITORY, python

import stickslip
from stickslip import _program

VERSION = metadata.version("stickslip")
WHICH = "import stickslip; print(stickslip.program(), stickslip.__file__, stickslip.__version__, sep='\\n')"


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `pip install --target` makes of the wheel."""
    folder = tmp_path_factory.mktemp("target") / "for a cluster"
    [wheel] = (REPOSITORY / "target" / "local").glob(f"stickslip-*_{platform.machine()}.whl")
    install(wheel, "--target", str(folder))
    return folder


@pytest.fixture(autouse=True)
def fresh() -> Iterator[None]:
    """Nothing is remembered of another test."""
    _program._beside_the_module.cache_clear()
    yield
    _program._beside_the_module.cache_clear()


def install(wheel: Path, *options: str) -> None:
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", *options, str(wheel)]
    subprocess.run(command, check=True)


def own_program() -> Path:
    return Path(sysconfig.get_path("scripts")) / "stickslip"


def other_version(folder: Path, version: str) -> Path:
    """A folder for the path with a program that says it has another version."""
    folder.mkdir()
    program = folder / "stickslip"
    program.write_text(f"#!/bin/sh\necho stickslip {version}\n", encoding="utf-8")
    program.chmod(0o755)
    return folder


def test_the_program_of_the_environment() -> None:
    assert stickslip.program() == own_program()
    assert stickslip.__version__ == VERSION


def test_the_environment_variable_wins(stub: Any) -> None:
    path = stub("print('stickslip 9.9.9')")
    assert stickslip.program() == path
    os.environ["STICKSLIP_PROGRAM"] = "/nowhere/stickslip"
    with pytest.raises(stickslip.ProgramNotFoundError, match="names /nowhere/stickslip, which is not a program"):
        stickslip.analyse()


def test_another_version_first_on_the_path_is_not_taken(place: Path) -> None:
    path = f"{other_version(place / 'other', '9.9.9')}{os.pathsep}{os.environ['PATH']}"
    answer = python(WHICH, folder=place, PATH=path)
    assert answer.stdout.splitlines()[0] == str(own_program()), answer.stderr


def test_pip_install_target(target: Path, place: Path) -> None:
    answer = python(WHICH, folder=place, PYTHONPATH=str(target))
    program, module, version = answer.stdout.splitlines()
    assert (program, version) == (str(target / "bin" / "stickslip"), VERSION), answer.stderr
    assert Path(module).is_relative_to(target)
    ran = python("import stickslip; print(stickslip.analyse()['stable'])", folder=place, PYTHONPATH=str(target))
    assert ran.stdout == "True\n", ran.stderr


def test_pip_install_prefix_and_user(target: Path, place: Path) -> None:
    [wheel] = (REPOSITORY / "target" / "local").glob(f"stickslip-*_{platform.machine()}.whl")
    install(wheel, "--prefix", str(place / "prefix"), "--ignore-installed")
    [site] = (place / "prefix").glob("lib*/python*/site-packages")
    answer = python(WHICH, folder=place, PYTHONPATH=str(site))
    assert answer.stdout.splitlines()[0] == str(place / "prefix" / "bin" / "stickslip"), answer.stderr
    # The user's own folder has the same layout below PYTHONUSERBASE.
    answer = python(WHICH, folder=place, PYTHONPATH=str(site), PYTHONUSERBASE=str(place / "prefix"))
    assert answer.stdout.splitlines()[0] == str(place / "prefix" / "bin" / "stickslip"), answer.stderr


def test_a_package_without_its_program_takes_none_of_another_version(target: Path, place: Path) -> None:
    shutil.copytree(target, place / "bare")
    (place / "bare" / "bin" / "stickslip").unlink()
    path = f"{other_version(place / 'other', '9.9.9')}{os.pathsep}/usr/bin:/bin"
    answer = python(WHICH, folder=place, PYTHONPATH=str(place / "bare"), PATH=path)
    assert answer.returncode == 1
    message = answer.stderr[answer.stderr.index("ProgramNotFoundError") :]
    assert f"stickslip, version {VERSION}" in message
    assert f"{place / 'other' / 'stickslip'} (on the path): 9.9.9" in message
    assert f"{place / 'bare' / 'bin' / 'stickslip'}: not there" in message
    assert "STICKSLIP_PROGRAM" in message
    # One of the same version will do.
    path = f"{own_program().parent}{os.pathsep}{path}"
    answer = python(WHICH, folder=place, PYTHONPATH=str(place / "bare"), PATH=path)
    assert answer.stdout.splitlines()[0] == str(own_program()), answer.stderr


def test_a_source_tree_has_the_program_that_is_installed_with_it(place: Path) -> None:
    # So does an editable install: the module is in the source tree, the program where the distribution is.
    answer = python(WHICH, folder=place, PYTHONPATH=str(REPOSITORY / "python"))
    program, module, _ = answer.stdout.splitlines()
    assert program == str(own_program()), answer.stderr
    assert Path(module).is_relative_to(REPOSITORY / "python")


@pytest.mark.skipif("STICKSLIP_EDITABLE" not in os.environ, reason="it builds the program: set STICKSLIP_EDITABLE")
def test_an_editable_install(tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "new"], check=True)
    new = tmp_path / "new" / "bin" / "python"
    # The libraries of this environment, and the builder, without asking an index.
    [site] = (tmp_path / "new").glob("lib/python*/site-packages")
    (site / "zz-others.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    path = f"{sysconfig.get_path('scripts')}{os.pathsep}{os.environ['PATH']}"
    command = [new, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--no-build-isolation", "-e"]
    subprocess.run([*command, REPOSITORY], check=True, env={**os.environ, "PATH": path})
    answer = subprocess.run([new, "-c", WHICH], check=True, capture_output=True, text=True, cwd=tmp_path)
    program, module, version = answer.stdout.splitlines()
    assert program == str(tmp_path / "new" / "bin" / "stickslip")
    assert (Path(module).parent, version) == (REPOSITORY / "python" / "stickslip", VERSION)


def test_python_m_is_the_program(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    command = [sys.executable, "-m", "stickslip"]
    version = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True)
    assert version.stdout.startswith(f"stickslip {VERSION}\ncommit: ")
    wrong = subprocess.run([*command, "submit", "nothing.toml"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 74 and wrong.stderr.startswith("stickslip: cannot read nothing.toml")
    monkeypatch.setenv("STICKSLIP_PROGRAM", "/nowhere")
    lost = subprocess.run(command, capture_output=True, text=True, check=False)
    assert lost.returncode == 1 and lost.stderr.startswith("stickslip: STICKSLIP_PROGRAM names /nowhere")


def test_the_wheel_has_what_belongs_in_it() -> None:
    files = {str(file) for file in metadata.files("stickslip") or []}
    assert {"stickslip/__init__.py", "stickslip/py.typed"} <= files
    licences = {file.rsplit("/", 1)[-1] for file in files if "/licenses/" in file}
    assert {"LICENSE-MIT", "LICENSE-APACHE", "plotly-license.txt"} <= licences
    about = metadata.metadata("stickslip")
    assert about["License-Expression"] == "MIT OR Apache-2.0"
    assert set(about.get_all("Provides-Extra") or []) == {"pandas", "polars", "xarray", "notebook"}
    wanted = (REPOSITORY / "Cargo.toml").read_text(encoding="utf-8")
    assert f'version = "{VERSION}"' in wanted
