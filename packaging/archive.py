"""The program with its manual, licences and list of parts as an archive:

    python packaging/archive.py TARGET WHEEL PROGRAM FOLDER

Program, licences and list of parts are those of the wheel. PROGRAM is one that runs on this machine and writes the
manual and the completions; "-" stands for that of the wheel. The archive goes to FOLDER, with its checksum beside it.
SOURCE_DATE_EPOCH is the time of all files in it. The same commit gives the same bytes.
"""

from __future__ import annotations

import hashlib
import io
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

import parts
from wheel import BILL, LICENCES, name_of_program

#: What a user reads or runs besides the program. The README is that of the archive.
DOCUMENTS = ["CHANGELOG.md", "CITATION.cff", "LICENSE-*", "jobs/**/*"]

#: What lists the digests of all other files.
CHECKSUMS = "SHA256SUMS"


def fill(folder: Path, wheel: Path, host_program: str) -> None:
    """Puts everything into the folder of the archive."""
    program = folder / "bin" / "stickslip"
    program.parent.mkdir(parents=True)
    with zipfile.ZipFile(wheel) as files:
        program.write_bytes(files.read(name_of_program(files)))
        for name in files.namelist():
            if name.endswith((f"/licenses/{LICENCES}", f"/sboms/{BILL}")):
                (folder / Path(name).name).write_bytes(files.read(name))
    program.chmod(0o755)
    writer = str(program) if host_program == "-" else host_program
    share = parts.REPOSITORY / "packaging" / "share.sh"
    subprocess.run([str(share), writer, str(folder / "share")], check=True)
    shutil.copyfile(parts.REPOSITORY / "packaging" / "README.md", folder / "README.md")
    for pattern in DOCUMENTS:
        for path in parts.REPOSITORY.glob(pattern):
            if path.is_file():
                copy = folder / path.relative_to(parts.REPOSITORY)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, copy)
    files = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    _write(folder / CHECKSUMS, "".join(f"{_digest(folder / name)}  {name}\n" for name in files))


def packed(folder: Path, epoch: int) -> bytes:
    """The folder as an archive that records nothing of who packed it, when and where."""
    plain = io.BytesIO()
    with tarfile.open(fileobj=plain, mode="w", format=tarfile.GNU_FORMAT) as archive:
        for path in sorted([folder, *folder.rglob("*")], key=lambda path: path.relative_to(folder).parts):
            entry = tarfile.TarInfo(path.relative_to(folder.parent).as_posix())
            entry.mtime = epoch
            if path.is_dir():
                entry.type, entry.mode = tarfile.DIRTYPE, 0o755
                archive.addfile(entry)
            else:
                entry.size, entry.mode = path.stat().st_size, 0o755 if path.parent.name == "bin" else 0o644
                with path.open("rb") as file:
                    archive.addfile(entry, file)
    # Without the name and the time of a file. Every gzip gives the same bytes, Python's library does not.
    command = ["gzip", "--no-name", "--best"]
    packed = subprocess.run(command, check=True, input=plain.getvalue(), stdout=subprocess.PIPE).stdout
    return packed


def main() -> None:
    """Makes the archive that the command line asks for."""
    target, wheel, host_program, out = sys.argv[1:]
    epoch = parts.epoch()
    name = f"stickslip-{target}-v{parts.version()}"
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place, name)
        fill(folder, Path(wheel), host_program)
        archive = Path(out, f"{name}.tar.gz")
        archive.write_bytes(packed(folder, epoch))
    _write(archive.with_name(f"{archive.name}.sha256"), f"{_digest(archive)}  {archive.name}\n")
    print(archive)


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


if __name__ == "__main__":
    try:
        main()
    except parts.PackagingError as error:
        sys.exit(f"packaging: {error}")
