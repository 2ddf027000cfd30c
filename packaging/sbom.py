"""The parts of the program for other programs: a bill of materials in the format CycloneDX 1.5.

Cargo lists the crates, Cargo.lock their checksums. What else is in the program is added to them. The bill says nothing of
where it was made, and its time is SOURCE_DATE_EPOCH, so that the same program has the same bill.
"""

from __future__ import annotations

import hashlib
import json
import re
import time
from typing import Any

from parts import REPOSITORY, PackagingError, Part, epoch, metadata


def bill_of_crates(target: str) -> dict[str, Any]:
    """The bill of the crates that the program is built from for a target, but for those that only its tests and build
    scripts need. Procedural macros count, as what they write is compiled too."""
    known = metadata("--filter-platform", target)
    packages = {package["id"]: package for package in known["packages"]}
    needs = {
        node["id"]: [one["pkg"] for one in node["deps"] if any(kind["kind"] is None for kind in one["dep_kinds"])]
        for node in known["resolve"]["nodes"]
    }
    [program] = [identity for identity, package in packages.items() if package["name"] == "stickslip"]
    reached, waiting = set(), [program]
    while waiting:
        identity = waiting.pop()
        if identity not in reached:
            reached.add(identity)
            waiting += needs[identity]
    checksums = _checksums()
    # Identities of crates of the repository have its place in them; names do not.
    crates = sorted((packages[identity] for identity in reached - {program}), key=lambda one: (one["name"], one["version"]))
    own = {**_crate(packages[program], checksums), "type": "application"}
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "timestamp": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(epoch())),
            "component": own,
        },
        "components": [_crate(package, checksums) for package in crates],
        "dependencies": [
            {"ref": _url(package), "dependsOn": sorted(_url(packages[one]) for one in needs[package["id"]])}
            for package in [packages[program], *crates]
        ],
    }


def _checksums() -> dict[tuple[str, str], str]:
    """The checksum of every crate of a registry, by name and version."""
    lock = (REPOSITORY / "Cargo.lock").read_text(encoding="utf-8")
    entry = re.compile(r'^name = "(.+)"\nversion = "(.+)"\nsource = ".+"\nchecksum = "(.+)"$', re.MULTILINE)
    return {(name, version): checksum for name, version, checksum in entry.findall(lock)}


def _url(package: dict[str, Any]) -> str:
    return f"pkg:cargo/{package['name']}@{package['version']}"


def _crate(package: dict[str, Any], checksums: dict[tuple[str, str], str]) -> dict[str, Any]:
    """A crate as a part. An old form of its licence has a stroke where an expression has OR."""
    if package["license"] is None:
        raise PackagingError(f"{package['name']} {package['version']} names no licence")
    url = _url(package)
    checksum = checksums.get((package["name"], package["version"]))
    return {
        "type": "library",
        "bom-ref": url,
        "name": package["name"],
        "version": package["version"],
        **({} if checksum is None else {"hashes": [{"alg": "SHA-256", "content": checksum}]}),
        "licenses": [{"expression": re.sub(r"\s*/\s*", " OR ", package["license"])}],
        "purl": url,
    }


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
