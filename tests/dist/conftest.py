"""The archive and the wheel of `make local` or `make dist` for this machine, and the tools that look at them."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parent.parent.parent
TARGET = f"{platform.machine()}-unknown-linux-gnu"

sys.path.insert(0, str(REPOSITORY / "packaging"))


def tool(name: str) -> str:
    """A program that a test needs. Without it the test is left out, but in continuous integration it fails."""
    found = shutil.which(name)
    if found is None:
        assert "CI" not in os.environ, f"{name} is not installed"
        pytest.skip(f"{name} is not installed")
    return found


def output(*command: object, **options: object) -> str:
    """What a command prints, which must succeed."""
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, check=False, **options)  # type: ignore[call-overload]
    assert done.returncode == 0, f"{words}\n{done.stdout}{done.stderr}"
    return done.stdout


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--packages FOLDER` is where the packages are."""
    parser.addoption("--packages", type=Path, required=True)


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "release: holds for the packages of a release only")


@pytest.fixture(scope="session")
def packages(pytestconfig: pytest.Config) -> Path:
    """The folder of the packages."""
    return (REPOSITORY / pytestconfig.getoption("packages")).resolve()


@pytest.fixture(scope="session")
def archive(packages: Path) -> Path:
    """The archive."""
    import parts

    return packages / f"stickslip-{TARGET}-v{parts.version()}.tar.gz"


@pytest.fixture(scope="session")
def folder(archive: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a user gets who unpacks it."""
    place = tmp_path_factory.mktemp("a place with spaces")
    with tarfile.open(archive) as files:
        files.extractall(place)
    [folder] = place.iterdir()
    return folder


@pytest.fixture(scope="session")
def wheel(packages: Path) -> zipfile.ZipFile:
    """The wheel."""
    [path] = packages.glob(f"stickslip-*_{platform.machine()}.whl")
    return zipfile.ZipFile(path)


@pytest.fixture(scope="session")
def crates() -> set[tuple[str, str]]:
    """Name and version of every crate that is linked into the program, as cargo lists them."""
    options = ["--locked", "--package", "stickslip", "--edges", "normal", "--target", TARGET]
    lines = output("cargo", "tree", *options, "--prefix", "none", "--format", "{p}", cwd=REPOSITORY)
    words = [line.split() for line in lines.splitlines()]
    return {(name, version.removeprefix("v")) for name, version, *_ in words}
