"""Manual pages and completions, in the archive and as `make install` puts them."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest
from conftest import REPOSITORY, output, tool


def commands(folder: Path) -> list[str]:
    """The commands of the program."""
    listed = output(folder / "bin" / "stickslip", "--help").split("Options:\n")[0]
    return re.findall(r"^  (\S+)", listed, re.MULTILINE)


def test_every_command_has_a_page(folder: Path) -> None:
    pages = {path.name for path in (folder / "share" / "man" / "man1").iterdir()}
    assert pages == {"stickslip.1"} | {f"stickslip-{command}.1" for command in commands(folder)}
    assert len(pages) > 20


@pytest.mark.parametrize("reader", [["man", "--warnings", "-l"], ["mandoc", "-T", "lint", "-W", "error"]])
def test_pages_are_read_without_errors(folder: Path, reader: list[str]) -> None:
    for page in sorted((folder / "share" / "man" / "man1").iterdir()):
        environment = {"MANWIDTH": "80", "LC_ALL": "C.UTF-8", "PATH": "/usr/bin:/bin"}
        words = [tool(reader[0]), *reader[1:], str(page)]
        done = subprocess.run(words, capture_output=True, text=True, check=False, env=environment)
        assert done.returncode == 0 and done.stderr == "", f"{page.name}: {done.stdout}{done.stderr}"
        if reader[0] == "man":
            assert all(word in done.stdout for word in ["NAME", "SYNOPSIS", "OPTIONS"]), done.stdout


def test_bash_completes_commands(folder: Path) -> None:
    script = folder / "share" / "bash-completion" / "completions" / "stickslip"
    asked = 'source "$1"; COMP_WORDS=(stickslip sub); COMP_CWORD=1; _stickslip stickslip sub stickslip; echo "${COMPREPLY[@]}"'
    assert output(tool("bash"), "-c", asked, "bash", script).split() == ["submit"]


def test_zsh_completes_commands(folder: Path) -> None:
    script = folder / "share" / "zsh" / "site-functions" / "_stickslip"
    output(tool("zsh"), "-n", script)
    asked = 'fpath=("$1" $fpath); autoload -Uz compinit && compinit -u -D && print -r -- $_comps[stickslip]'
    assert output(tool("zsh"), "-f", "-c", asked, "zsh", script.parent).strip() == "_stickslip"


def test_fish_completes_commands(folder: Path) -> None:
    script = folder / "share" / "fish" / "vendor_completions.d" / "stickslip.fish"
    output(tool("fish"), "--no-execute", script)
    asked = "source $argv[1]; complete --do-complete 'stickslip sub'"
    assert output(tool("fish"), "--no-config", "-c", asked, script).split()[0] == "submit"


def test_install_puts_everything_in_its_place_and_uninstall_takes_it_away(folder: Path, tmp_path: Path) -> None:
    program = folder / "bin" / "stickslip"
    # Make splits the names of programs at spaces.
    (tmp_path / "program").symlink_to(program)
    stage, prefix = tmp_path / "a stage", "/opt/for everybody"
    where = [f"PROGRAM={tmp_path / 'program'}", f"DESTDIR={os.path.relpath(stage, REPOSITORY)}", f"PREFIX={prefix}"]
    make = [tool("make"), "--no-print-directory", "-C", str(REPOSITORY)]
    output(*make, "install", *where, umask=0o077)
    place = Path(f"{stage}{prefix}")
    installed = {path.relative_to(place) for path in place.rglob("*") if path.is_file()}
    archived = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    assert installed == {path for path in archived if path.parts[0] in ("bin", "share")}
    for path in installed:
        assert (place / path).read_bytes() == (folder / path).read_bytes(), path
        assert (place / path).stat().st_mode & 0o7777 == (0o755 if path.parts[0] == "bin" else 0o644), path
    assert all(path.stat().st_mode & 0o755 == 0o755 for path in place.rglob("*") if path.is_dir())

    beside = place / "share" / "man" / "man1" / "other.1"
    beside.write_text("the page of another program")
    output(*make, "uninstall", *where)
    assert [path for path in place.rglob("*") if not path.is_dir()] == [beside]
    # Again, where there is nothing.
    output(*make, "uninstall", *where)
