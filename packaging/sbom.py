"""The parts of the program for other programs: a bill of materials in the format CycloneDX 1.5.

cargo-cyclonedx lists the crates. What else is in the program is added here. With SOURCE_DATE_EPOCH set, the same program
has the same bill.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from typing import Any

from parts import REPOSITORY, Part, run

#: The name under which cargo-cyclonedx writes a bill beside the manifest of every crate of the workspace.
WRITTEN = "unfinished.cdx"


def bill_of_crates(target: str) -> dict[str, Any]:
    """The bill of the crates that the program is built from for a target, but for those that only its tests and build
    scripts need. Procedural macros count, as what they write is compiled too."""
    options = ["--format", "json", "--spec-version", "1.5", "--no-build-deps", "--quiet", "--override-filename", WRITTEN]
    # It writes beside the manifests, and cargo would build again what lies in a folder that has changed.
    times = {folder: folder.stat() for folder in REPOSITORY.glob("crates/*")}
    try:
        run(os.environ.get("CARGO", "cargo"), "cyclonedx", "--target", target, *options)
        text = (REPOSITORY / "crates" / "runner" / f"{WRITTEN}.json").read_text(encoding="utf-8")
    finally:
        for written in REPOSITORY.glob(f"crates/*/{WRITTEN}.json"):
            written.unlink()
        for folder, before in times.items():
            os.utime(folder, ns=(before.st_atime_ns, before.st_mtime_ns))
    # Crates of the repository are named by where it lies.
    text = re.sub(r'path\+file://[^"#]*#', "pkg:cargo/", text)
    return json.loads(re.sub(r'\?download_url=file:[^"#]*', "", text))


def bill_of_materials(bill: dict[str, Any], others: list[Part], binary: bytes, target: str) -> str:
    """The bill of a program for a target: that of its crates, and other parts."""
    program = bill["metadata"]["component"]
    program["hashes"] = [{"alg": "SHA-256", "content": hashlib.sha256(binary).hexdigest()}]
    program["properties"] = [{"name": "stickslip:target", "value": target}]
    bill["components"] += [_component(part) for part in others]
    [needs] = [one for one in bill["dependencies"] if one["ref"] == program["bom-ref"]]
    needs["dependsOn"] += [part.url for part in others]
    bill["dependencies"] += [{"ref": part.url} for part in others]
    return json.dumps(bill, indent=1, ensure_ascii=False) + "\n"


def _component(part: Part) -> dict[str, Any]:
    return {
        "type": "library",
        "bom-ref": part.url,
        "name": part.name,
        "version": part.version,
        "licenses": [{"expression": part.licence}],
        "purl": part.url,
    }
