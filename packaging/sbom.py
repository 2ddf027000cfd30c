"""The parts of the program for other programs: a bill of materials in the format CycloneDX 1.5."""

from __future__ import annotations

import hashlib
import json
import uuid
from datetime import datetime, timezone
from typing import Any

from parts import Part


def bill_of_materials(program: Part, parts: list[Part], binary: bytes, target: str, epoch: int) -> str:
    """The bill of a program for a target. `epoch` is the time that it tells, in seconds."""
    digest = hashlib.sha256(binary).hexdigest()
    built_in = [part.url for part in parts if part.checksum is None and not part.url.startswith("pkg:cargo/")]
    component = _component(program, "application")
    component["hashes"] = [{"alg": "SHA-256", "content": digest}]
    component["properties"] = [{"name": "stickslip:target", "value": target}]
    dependencies = [{"ref": program.url, "dependsOn": sorted([*program.needs, *built_in])}]
    dependencies += [{"ref": part.url, "dependsOn": part.needs} for part in parts]
    bill = {
        "$schema": "http://cyclonedx.org/schema/bom-1.5.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        # The same program has the same number.
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, f'{program.url}#{target}#{digest}')}",
        "version": 1,
        "metadata": {
            "timestamp": datetime.fromtimestamp(epoch, timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ"),
            "component": component,
        },
        "components": [_component(part, "library") for part in parts],
        "dependencies": dependencies,
    }
    return json.dumps(bill, indent=1, ensure_ascii=False) + "\n"


def _component(part: Part, kind: str) -> dict[str, Any]:
    component: dict[str, Any] = {
        "type": kind,
        "bom-ref": part.url,
        "name": part.name,
        "version": part.version,
        "licenses": [{"expression": part.licence}],
        "purl": part.url,
    }
    if part.description:
        component["description"] = part.description
    if part.checksum:
        component["hashes"] = [{"alg": "SHA-256", "content": part.checksum}]
    return component
