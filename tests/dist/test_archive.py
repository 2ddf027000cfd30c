"""The archive as a file, and the program in it."""

from __future__ import annotations

import gzip
import os
import re
import tarfile
import zipfile
from pathlib import Path

import pytest
from conftest import REPOSITORY, TARGET, output, tool


def test_it_is_one_folder_that_records_nothing_of_who_packed_it(archive: Path) -> None:
    packed = archive.read_bytes()
    # Flags and time of RFC 1952: no name of a file, no time.
    assert packed[:2] == b"\x1f\x8b" and packed[3:8] == bytes(5)
    with tarfile.open(archive) as files:
        members = files.getmembers()
    names = [member.name for member in members]
    root = archive.name.removesuffix(".tar.gz")
    assert names[0] == root and all(name.startswith(f"{root}/") for name in names[1:])
    assert [name.split("/") for name in names] == sorted(name.split("/") for name in names)
    for member in members:
        assert (member.uid, member.gid, member.uname, member.gname) == (0, 0, "", ""), member.name
        assert member.mtime == int(os.environ["SOURCE_DATE_EPOCH"]), member.name
        is_program = member.isdir() or member.name == f"{root}/bin/stickslip"
        assert member.mode == (0o755 if is_program else 0o644), member.name
    assert len(gzip.decompress(packed)) % 512 == 0


def test_it_holds_what_it_should(folder: Path) -> None:
    for name in [
        "bin/stickslip",
        "share/man/man1/stickslip.1",
        "share/bash-completion/completions/stickslip",
        "share/zsh/site-functions/_stickslip",
        "share/fish/vendor_completions.d/stickslip.fish",
        "share/stickslip/completions/stickslip.elv",
        "share/stickslip/completions/stickslip.ps1",
        "README.md",
        "THIRD-PARTY-LICENSES",
        "stickslip.cdx.json",
        "SHA256SUMS",
    ]:
        assert (folder / name).stat().st_size > 0, name
    copied = ["CHANGELOG.md", "CITATION.cff", "LICENSE-MIT", "LICENSE-APACHE"]
    copied += [path.relative_to(REPOSITORY).as_posix() for path in (REPOSITORY / "jobs").rglob("*") if path.is_file()]
    for name in copied:
        assert (folder / name).read_bytes() == (REPOSITORY / name).read_bytes(), name


def test_checksums_cover_every_file(archive: Path, folder: Path) -> None:
    output(tool("sha256sum"), "--check", "--strict", "SHA256SUMS", cwd=folder)
    listed = {line.split("  ", 1)[1] for line in (folder / "SHA256SUMS").read_text().splitlines()}
    there = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert listed == there - {"SHA256SUMS"}
    output(tool("sha256sum"), "--check", "--strict", f"{archive.name}.sha256", cwd=archive.parent)


def test_the_program_is_that_of_the_wheel(folder: Path, wheel: zipfile.ZipFile) -> None:
    [name] = [name for name in wheel.namelist() if name.endswith("/stickslip") and ".data/scripts/" in name]
    assert wheel.read(name) == (folder / "bin" / "stickslip").read_bytes()


@pytest.mark.release
def test_it_needs_no_newer_library_than_glibc_2_17(folder: Path) -> None:
    program = folder / "bin" / "stickslip"
    versions = re.findall(r"GLIBC_([0-9.]+)", output(tool("objdump"), "-T", program))
    assert len(versions) > 50
    assert max(tuple(map(int, version.split("."))) for version in versions) <= (2, 17), sorted(set(versions))
    needed = set(re.findall(r"NEEDED +(\S+)", output(tool("objdump"), "-p", program)))
    of_glibc = r"(libc|libm|libdl|librt|libpthread)\.so\.[0-9]|ld-linux-.*"
    assert needed and all(re.fullmatch(of_glibc, library) for library in needed), needed


@pytest.mark.release
def test_no_path_of_the_build_is_in_it(folder: Path) -> None:
    program = (folder / "bin" / "stickslip").read_bytes()
    home = os.environ.get("CARGO_HOME", os.path.expanduser("~/.cargo"))
    sysroot = output("rustc", "--print", "sysroot").strip()
    for path in [REPOSITORY, REPOSITORY.parent, home, sysroot]:
        assert os.fsencode(f"{path}/") not in program, path


def test_it_prints_what_it_is(folder: Path) -> None:
    printed = output(folder / "bin" / "stickslip", "--version", env={})
    assert re.search(rf"^target: +{TARGET}$", printed, re.MULTILINE), printed
    commit = output("git", "log", "-1", "--format=%H", cwd=REPOSITORY).strip()
    assert re.search(rf"^commit: +{commit[:12]} ", printed, re.MULTILINE), printed


def test_it_runs_without_an_environment(folder: Path) -> None:
    text = output("./bin/stickslip", "submit", "jobs/fig14a.toml", cwd=folder, env={})
    assert "runs/fig14a/surface.parquet: 780 cells, 10,000 samples each" in text
    assert "surface.parquet: sound" in output("./bin/stickslip", "verify", "runs/fig14a", cwd=folder, env={})
