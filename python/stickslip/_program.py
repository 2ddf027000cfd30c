"""Where the program ``stickslip`` is that belongs to this package."""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

from ._errors import ProgramNotFoundError

#: The environment variable that names another program.
VARIABLE = "STICKSLIP_PROGRAM"

_NAME = "stickslip" + (sysconfig.get_config_var("EXE") or "")


def package_version() -> str | None:
    """The version of the installed package; ``None`` for a source tree that is not installed."""
    try:
        return metadata.version("stickslip")
    except metadata.PackageNotFoundError:
        return None


def program() -> Path:
    """Find the program.

    The environment variable ``STICKSLIP_PROGRAM`` wins. Otherwise it is the program that was installed together with
    this module. One that is elsewhere on the path is taken only if it has the version of this package.

    Raises
    ------
    ProgramNotFoundError
        If there is none, or only one of another version.
    """
    named = os.environ.get(VARIABLE)
    if named:
        path = Path(named).expanduser()
        if not _is_program(path):
            raise ProgramNotFoundError(f"{VARIABLE} names {path}, which is not a program that can be run")
        return path.absolute()
    return _beside_the_module(os.environ.get("PATH", os.defpath))


@functools.lru_cache(maxsize=8)
def _beside_the_module(search_path: str) -> Path:
    wanted = package_version()
    looked: list[str] = []
    candidates = [(place / _NAME, True) for place in _script_folders(_module_folder())]
    found = shutil.which(_NAME, path=search_path)
    if found:
        candidates.append((Path(found).absolute(), False))
    for path, is_own in candidates:
        if any(line.startswith(f"{path}: ") for line in looked):
            continue
        if not _is_program(path):
            looked.append(f"{path}: not there")
            continue
        version = _version_of(path)
        if wanted is not None and version == wanted:
            return path
        # A source tree that is not installed has no version to compare with.
        looked.append(f"{path}{'' if is_own else ' (on the path)'}: {version or 'no stickslip'}")
    package = f"version {wanted}" if wanted else "not installed, so that its version is not known"
    places = "\n".join(f"  {line}" for line in looked)
    raise ProgramNotFoundError(
        f"there is no program that belongs to this Python package (stickslip, {package}). Looked at\n{places}\n"
        f"Install the package again, or name the program in the environment variable {VARIABLE}"
    )


def _module_folder() -> Path:
    """The folder that holds the package: ``site-packages``, that of ``pip install --target``, or a source tree."""
    return Path(__file__).resolve().parent.parent


def _script_folders(site: Path) -> Iterator[Path]:
    """Where an installer puts programs, nearest to a module in ``site`` first."""
    # pip install --target
    yield site / "bin"
    # A virtual environment, a prefix or the user's own folder, PREFIX/lib/python3.11/site-packages. Debian names the
    # last part dist-packages.
    parts = [part.lower() for part in site.parts[-3:]]
    if len(parts) == 3 and parts[0] in ("lib", "lib64") and parts[2] in ("site-packages", "dist-packages"):
        yield site.parents[2] / "bin"
    # The scheme of the interpreter has it if it is laid out in another way.
    for scheme in dict.fromkeys([sysconfig.get_default_scheme(), sysconfig.get_preferred_scheme("user")]):
        paths = sysconfig.get_paths(scheme)
        if site in (Path(paths["purelib"]).resolve(), Path(paths["platlib"]).resolve()):
            yield Path(paths["scripts"])
    # An editable install has the module in a source tree, and the program where the distribution is.
    try:
        files = metadata.distribution("stickslip").files or []
    except metadata.PackageNotFoundError:
        return
    for file in files:
        if file.name == _NAME and file.parent.name.lower() in ("bin", "scripts"):
            yield Path(os.path.normpath(str(file.locate()))).parent


def _is_program(path: Path) -> bool:
    return path.is_file() and os.access(path, os.X_OK)


def _version_of(path: Path) -> str | None:
    """What a program says its version is; ``None`` if it is no stickslip."""
    try:
        answer = subprocess.run(
            [path, "-V"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=20,
            check=True,
            text=True,
            errors="replace",
        )
    except (OSError, subprocess.SubprocessError):
        return None
    name, _, version = answer.stdout.strip().partition(" ")
    return version if name == "stickslip" else None


def replace_this_process() -> None:
    """Run the program with the arguments of this process, in its place: ``python -m stickslip``."""
    try:
        path = program()
    except ProgramNotFoundError as error:
        sys.exit(f"stickslip: {error}")
    arguments = [str(path), *sys.argv[1:]]
    if os.name == "posix":
        sys.stdout.flush()
        os.execv(path, arguments)
    sys.exit(subprocess.run(arguments, check=False).returncode)
