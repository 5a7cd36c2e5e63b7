"""The list of what a bundle is made of, as CycloneDX 1.6 in JSON: programs that look for known weaknesses read it."""

import json
import uuid
from collections.abc import Sequence
from pathlib import Path

from inventory import Part
from release import NAME, Release

_FORMAT = "1.6"


def bill_of_materials(release: Release, parts: Sequence[Part]) -> dict[str, object]:
    """The document. It is the same for the same release and parts, serial number and time included."""
    own = f"pkg:pypi/{NAME}@{release.version}"
    components = [_component(part) for part in parts]
    identity = json.dumps([own, release.system, components], sort_keys=True)
    return {
        "$schema": f"http://cyclonedx.org/schema/bom-{_FORMAT}.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": _FORMAT,
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, identity)}",
        "version": 1,
        "metadata": {
            "timestamp": release.time.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "lifecycles": [{"phase": "build"}],
            "component": {
                "type": "application",
                "bom-ref": own,
                "name": NAME,
                "version": release.version,
                "licenses": [{"license": {"id": "MIT"}}],
                "purl": own,
                "properties": [{"name": "system", "value": release.system}],
            },
        },
        "components": components,
        "dependencies": [
            {"ref": own, "dependsOn": sorted(_reference(part) for part in parts)},
            *({"ref": _reference(part)} for part in parts),
        ],
    }


def write_bill(path: Path, release: Release, parts: Sequence[Part]) -> None:
    text = json.dumps(bill_of_materials(release, parts), indent=2, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")


def _reference(part: Part) -> str:
    return part.purl or f"{part.name}@{part.version}"


def _component(part: Part) -> dict[str, object]:
    component: dict[str, object] = {
        "type": "library",
        "bom-ref": _reference(part),
        "name": part.name,
        "version": part.version,
    }
    if part.licence is not None:
        component["licenses"] = _licences(part.licence)
    if part.purl is not None:
        component["purl"] = part.purl
    return component


def _licences(expression: str) -> list[dict[str, object]]:
    is_one = not {" AND ", " OR ", " WITH "} & {f" {word} " for word in expression.split()}
    return [{"license": {"id": expression}}] if is_one else [{"expression": expression}]
