"""Puts into a wheel what maturin cannot: the licences of everything in the program, and the list of its parts.

    python packaging/wheel.py TARGET WHEEL

What is in the wheel already keeps its bytes. SOURCE_DATE_EPOCH is the time of what is added.
"""

from __future__ import annotations

import base64
import hashlib
import stat
import sys
import time
import zipfile
from pathlib import Path

import parts
from licences import third_party_licences
from sbom import bill_of_crates, bill_of_materials

LICENCES = "THIRD-PARTY-LICENSES"
BILL = "stickslip.cdx.json"


def name_of_program(files: zipfile.ZipFile) -> str:
    """Where the program lies in a wheel."""
    [name] = [name for name in files.namelist() if name.endswith(".data/scripts/stickslip")]
    return name


def complete(wheel: Path, target: str, epoch: int) -> None:
    """Adds the licences and the list of parts."""
    bill = bill_of_crates(target)
    others = parts.embedded() + parts.toolchain()
    with zipfile.ZipFile(wheel) as files:
        [information] = {name.split("/")[0] for name in files.namelist() if ".dist-info/" in name}
        binary = files.read(name_of_program(files))
        metadata = files.read(f"{information}/METADATA").decode()
        record = files.read(f"{information}/RECORD").decode()
    before = "License-File: LICENSE-MIT\n"
    if before not in metadata:
        raise parts.PackagingError(f"no line {before!r} in METADATA")
    added = {
        f"{information}/METADATA": metadata.replace(before, f"{before}License-File: {LICENCES}\n").encode(),
        f"{information}/licenses/{LICENCES}": third_party_licences(parts.crates(bill, target) + others).encode(),
        f"{information}/sboms/{BILL}": bill_of_materials(bill, others, binary, target).encode(),
    }
    kept = [line for line in record.splitlines() if line.split(",")[0] not in added]
    lines = [f"{name},sha256={_digest(data)},{len(data)}" for name, data in added.items()]
    # The record itself comes last, without a digest.
    added[f"{information}/RECORD"] = "\n".join([*kept[:-1], *lines, kept[-1], ""]).encode()
    _replace(wheel, added, epoch)


def _digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def _replace(wheel: Path, added: dict[str, bytes], epoch: int) -> None:
    """Writes a wheel again with other files. Those that stay are copied as they are, compressed, and those that are added
    are not compressed, as every Python compresses in its own way."""
    old = wheel.read_bytes()
    unfinished = wheel.with_suffix(".unfinished")
    with zipfile.ZipFile(wheel) as before, zipfile.ZipFile(unfinished, "w") as after:
        entries = sorted(before.infolist(), key=lambda entry: entry.header_offset)
        ends = [entry.header_offset for entry in entries[1:]] + [before.start_dir]
        for entry, end in zip(entries, ends, strict=True):
            if entry.filename not in added:
                bytes_of_entry = old[entry.header_offset : end]
                entry.header_offset = after.fp.tell()
                after.fp.write(bytes_of_entry)
                after.filelist.append(entry)
                after.NameToInfo[entry.filename] = entry
        after.start_dir = after.fp.tell()
        for name, data in added.items():
            entry = zipfile.ZipInfo(name, time.gmtime(epoch)[:6])
            entry.create_system = 3
            entry.external_attr = (stat.S_IFREG | 0o644) << 16
            after.writestr(entry, data)
    unfinished.replace(wheel)


if __name__ == "__main__":
    try:
        complete(Path(sys.argv[2]), sys.argv[1], parts.epoch())
    except parts.PackagingError as error:
        sys.exit(f"packaging: {error}")
