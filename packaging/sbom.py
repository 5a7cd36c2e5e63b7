"""The list of what a bundle is made of, as CycloneDX 1.6 in JSON: programs that look for known weaknesses read it."""

import hashlib
import json
import uuid
from collections.abc import Sequence
from pathlib import Path

from bundle_contents import Entry
from inventory import Part, licence_folder
from release import NAME, Release

_FORMAT = "1.6"


_HASH_OF = "dps-s:hash-of"
_INSIDE = "dps-s:inside"
_NOTE = "dps-s:note"
_TEXTS = "dps-s:licence-texts"
LICENCES = "licences"


def bill_of_materials(release: Release, parts: Sequence[Part], internal: Path) -> dict[str, object]:
    """The document; `internal` is where the files of the parts lie in the bundle.

    It is the same for the same release and parts, serial number and time included.
    """
    own = f"pkg:pypi/{NAME}@{release.version}"
    components = [_component(part, internal) for part in parts]
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
            {"ref": own, "dependsOn": sorted(_reference(part) for part in parts if part.inside is None)},
            *({"ref": _reference(part)} for part in parts),
        ],
    }


def write_bill(path: Path, release: Release, parts: Sequence[Part], internal: Path) -> None:
    text = json.dumps(bill_of_materials(release, parts, internal), indent=2, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")


def _reference(part: Part) -> str:
    return part.purl or "@".join(filter(None, (part.inside, part.name, part.version)))


def _component(part: Part, internal: Path) -> dict[str, object]:
    component: dict[str, object] = {"type": "library", "bom-ref": _reference(part), "name": part.name}
    if part.version is not None:
        component["version"] = part.version
    sums = {file.place.replace("\\", "/"): _sum(file, internal) for file in part.files}
    component["hashes"] = _hashes(_sum_of_all(sums))
    component["licenses"] = _licences(part.licence)
    if part.purl is not None:
        component["purl"] = part.purl
    properties = {
        _INSIDE: part.inside,
        _NOTE: part.note,
        _HASH_OF: _what_is_hashed(part, sorted(sums)),
        _TEXTS: f"{LICENCES}/{licence_folder(part)}",
    }
    component["properties"] = [{"name": name, "value": value} for name, value in properties.items() if value]
    if part.inside is None:
        here = [place for place in sorted(sums) if (internal / place).is_file()]
        component["components"] = [{"type": "file", "name": one, "hashes": _hashes(sums[one])} for one in here]
    return component


def _sum(file: Entry, internal: Path) -> str:
    """Of the file as it is in the bundle; of a module in the executable, of what it was made from."""
    place = internal / file.place
    return hashlib.sha256((place if place.is_file() else Path(file.source)).read_bytes()).hexdigest()


def _sum_of_all(sums: dict[str, str]) -> str:
    if len(sums) == 1:
        return next(iter(sums.values()))
    lines = "".join(f"{sums[place]}  {place}\n" for place in sorted(sums))
    return hashlib.sha256(lines.encode()).hexdigest()


def _what_is_hashed(part: Part, places: list[str]) -> str:
    if len(places) == 1:
        return places[0]
    return f"what sha256sum prints for the {len(places)} files of {part.inside or part.name}, by name"


def _hashes(value: str) -> list[dict[str, str]]:
    return [{"alg": "SHA-256", "content": value}]


def _licences(expression: str) -> list[dict[str, object]]:
    is_one = not {"AND", "OR", "WITH"} & set(expression.split())
    if is_one and not expression.startswith("LicenseRef-"):
        return [{"license": {"id": expression}}]
    return [{"expression": expression}]
