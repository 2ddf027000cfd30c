"""The licences of what is in the program, and the list of its parts."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

import parts
import pytest
from conftest import REPOSITORY, TARGET
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator


def entries(text: str) -> dict[str, list[int]]:
    """The numbers of the texts of each part, by its name and version."""
    listed = text.split("=" * 120)[0]
    blocks = [block.splitlines() for block in listed.split("\n\n")[1:] if block.strip()]
    return {block[0].strip(): [int(n) for n in re.findall(r": text ([0-9]+)$", "\n".join(block), re.M)] for block in blocks}


def test_every_crate_has_its_licence(folder: Path, crates: set[tuple[str, str]]) -> None:
    text = (folder / "THIRD-PARTY-LICENSES").read_text()
    found = entries(text)
    numbers = [int(number) for number in re.findall(r"^={120}\nText ([0-9]+)\n={120}$", text, re.MULTILINE)]
    assert numbers == list(range(1, len(numbers) + 1))
    foreign = {(name, version) for name, version in crates if not name.startswith("stickslip")}
    assert len(foreign) > 50
    for name, version in foreign:
        assert found.get(f"{name} {version}"), f"{name} {version} has no text"
    assert {number for used in found.values() for number in used} == set(numbers)


def test_what_is_no_crate_has_its_licence(folder: Path) -> None:
    text = (folder / "THIRD-PARTY-LICENSES").read_text()
    for words in [
        "Plotly Technologies Inc",
        "Bitstream Vera",
        "Copyright notices for The Rust Standard Library",
        "Copyright (c) Zig contributors",
        "The LLVM Project is under the Apache License v2.0 with LLVM Exceptions",
        "GNU C Library",
    ]:
        assert words in text, words
    names = " ".join(entries(text))
    for name in ["plotly.js", "DejaVu", "rust-std", "libunwind", "compiler_rt"]:
        assert name in names


def test_a_crate_without_a_text_is_refused_unless_its_licence_has_a_standard_text(tmp_path: Path) -> None:
    assert parts.notices(tmp_path) == {}
    part = parts.Part("one", "1.0.0", "BSD-3-Clause", "pkg:cargo/one@1.0.0")
    with pytest.raises(parts.PackagingError, match="one 1.0.0 .BSD-3-Clause. brings no text"):
        parts._standard(part, ["A. Author"])
    part.licence = "MIT OR Apache-2.0"
    assert "Apache License" in parts._standard(part, [])["Apache-2.0"]
    # The text of MIT names who holds the rights, and that is not this project.
    part.licence = "MIT"
    for authors, holder in [(["A. Author", "B. Author"], "A. Author, B. Author"), ([], "the authors of one")]:
        text = parts._standard(part, authors)["MIT"]
        assert f"Copyright (c) {holder}\n" in text
        assert "Permission is hereby granted, free of charge" in text
        assert "stickslip" not in text
    # Not where another licence holds besides.
    part.licence = "Apache-2.0 AND MIT"
    with pytest.raises(parts.PackagingError):
        parts._standard(part, [])


def test_without_a_time_it_is_said_what_to_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    assert parts.epoch() == 1_700_000_000
    for text in ["", "now", "-1", "1.5"]:
        monkeypatch.setenv("SOURCE_DATE_EPOCH", text)
        with pytest.raises(parts.PackagingError, match=f"SOURCE_DATE_EPOCH is {re.escape(repr(text))}, and must be"):
            parts.epoch()
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    with pytest.raises(parts.PackagingError, match=r"is not set; .*SOURCE_DATE_EPOCH=\$\(git log"):
        parts.epoch()


def test_a_crate_with_notices_of_others_alone_gets_the_text_of_its_own_licence(folder: Path) -> None:
    text = (folder / "THIRD-PARTY-LICENSES").read_text()
    entry = text[text.index("\nfaer 0.") :]
    entry = entry[: entry.index("\n\n")]
    for name in ["COPYING.EIGEN.MPL2", "COPYING.LAPACK.BSD", "COPYING.SUITE_SPARSE.COLAMD.BSD", "MIT"]:
        assert f"    {name}: text " in entry, entry


def test_notices_are_found_and_sources_are_not(tmp_path: Path) -> None:
    for name in [
        "LICENSE-MIT",
        "COPYING",
        "COPYING.LAPACK.BSD",
        "NOTICE.txt",
        "UNLICENSE",
        "LICENSE-Apache-2.0_WITH_LLVM-exception",
        "licenses/one",
        "assets/fonts/LICENSE",
        "src/licensee.rs",
        "tests/LICENSE",
        "README.md",
    ]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("text \r\n")
    found = parts.notices(tmp_path)
    assert sorted(found) == [
        "COPYING",
        "COPYING.LAPACK.BSD",
        "LICENSE-Apache-2.0_WITH_LLVM-exception",
        "LICENSE-MIT",
        "NOTICE.txt",
        "UNLICENSE",
        "assets/fonts/LICENSE",
        "licenses/one",
    ]
    assert set(found.values()) == {"text\n"}


def test_the_list_of_parts_is_valid_and_complete(folder: Path, crates: set[tuple[str, str]]) -> None:
    text = (folder / "stickslip.cdx.json").read_text()
    error = JsonStrictValidator(SchemaVersion.V1_5).validate_str(text)
    assert error is None, error
    bill = json.loads(text)
    own, components = bill["metadata"]["component"], bill["components"]
    named = {(one["name"], one["version"]) for one in [own, *components]}
    assert crates <= named
    program = (folder / "bin" / "stickslip").read_bytes()
    assert own["hashes"] == [{"alg": "SHA-256", "content": hashlib.sha256(program).hexdigest()}]
    assert own["properties"] == [{"name": "stickslip:target", "value": TARGET}]
    lock = (REPOSITORY / "Cargo.lock").read_text()
    for one in components:
        is_of_registry = one["purl"].startswith("pkg:cargo/") and not one["name"].startswith("stickslip-")
        assert ("hashes" in one) == is_of_registry, one["name"]
        assert not is_of_registry or one["hashes"][0]["content"] in lock, one["name"]
    references = {own["bom-ref"]} | {one["bom-ref"] for one in components}
    assert len(references) == len(components) + 1
    assert {one["ref"] for one in bill["dependencies"]} == references
    assert str(REPOSITORY) not in text and "file:" not in text
    reached, waiting = set(), [own["bom-ref"]]
    needs = {one["ref"]: one.get("dependsOn", []) for one in bill["dependencies"]}
    while waiting:
        reference = waiting.pop()
        if reference not in reached:
            reached.add(reference)
            waiting += needs[reference]
    assert reached == references
