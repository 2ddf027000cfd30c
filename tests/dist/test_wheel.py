"""What is in the wheel besides what maturin puts there."""

from __future__ import annotations

import base64
import hashlib
import os
import sys
import time
import zipfile
from pathlib import Path

from conftest import REPOSITORY, output


def test_the_record_lists_what_is_in_it(wheel: zipfile.ZipFile) -> None:
    assert wheel.testzip() is None
    names = wheel.namelist()
    assert len(names) == len(set(names))
    [record] = [name for name in names if name.endswith(".dist-info/RECORD")]
    lines = [line.split(",") for line in wheel.read(record).decode().splitlines()]
    assert sorted(name for name, _, _ in lines) == sorted(names)
    for name, digest, size in lines:
        if name == record:
            assert digest == size == ""
            continue
        data = wheel.read(name)
        expected = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        assert (digest, int(size)) == (f"sha256={expected}", len(data)), name


def test_it_records_nothing_of_where_and_when_it_was_built(wheel: zipfile.ZipFile) -> None:
    epoch = int(os.environ["SOURCE_DATE_EPOCH"])
    for entry in wheel.infolist():
        # Times in archives have steps of two seconds.
        expected = time.gmtime(epoch)[:6]
        assert entry.date_time in (expected, (*expected[:5], expected[5] // 2 * 2)), entry.filename
        assert os.fsencode(f"{REPOSITORY}/") not in wheel.read(entry), entry.filename


def test_licences_and_parts_are_those_of_the_archive(folder: Path, wheel: zipfile.ZipFile) -> None:
    [metadata] = [name for name in wheel.namelist() if name.endswith(".dist-info/METADATA")]
    information = metadata.split("/")[0]
    licences = wheel.read(f"{information}/licenses/THIRD-PARTY-LICENSES")
    assert licences == (folder / "THIRD-PARTY-LICENSES").read_bytes()
    headers = wheel.read(metadata).decode().split("\n\n")[0].splitlines()
    files = [line.removeprefix("License-File: ") for line in headers if line.startswith("License-File: ")]
    assert "THIRD-PARTY-LICENSES" in files
    listed = {f"{information}/licenses/{name}" for name in files}
    assert listed == {name for name in wheel.namelist() if "/licenses/" in name}
    lists = [name for name in wheel.namelist() if "/sboms/" in name]
    assert lists == [f"{information}/sboms/stickslip.cdx.json"]
    assert wheel.read(lists[0]) == (folder / "stickslip.cdx.json").read_bytes()


def test_pip_installs_it(wheel: zipfile.ZipFile, folder: Path, tmp_path: Path) -> None:
    options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--no-index", "--target", tmp_path]
    output(sys.executable, "-m", "pip", "install", *options, wheel.filename)
    assert (tmp_path / "bin" / "stickslip").read_bytes() == (folder / "bin" / "stickslip").read_bytes()
