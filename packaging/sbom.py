"""The list of what a bundle is made of, as CycloneDX 1.6 in JSON, which scanners for known vulnerabilities read."""

import hashlib
import uuid
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from bundle_contents import Entry
from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.model import HashAlgorithm, HashType, Property
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.model.lifecycle import LifecyclePhase, PredefinedLifecycle
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL
from parts import Part, licence_folder
from release import NAME, Release

LICENCES = "licences"


def bill_of_materials(release: Release, parts: Sequence[Part], internal: Path) -> str:
    """The document; `internal` is where the files of the parts lie in the bundle.

    It is the same for the same release and parts, serial number and time included.
    """
    purl = f"pkg:pypi/{NAME}@{release.version}"
    own = Component(
        name=NAME, version=release.version, type=ComponentType.APPLICATION, bom_ref=purl,
        purl=PackageURL.from_string(purl), licenses=[LicenseFactory().make_from_string("MIT")],
        properties=_properties({"system": release.system}),
    )  # fmt: skip
    components = {_component(part, internal): part for part in parts}
    bom = Bom(components=components, serial_number=uuid.UUID(int=0))
    bom.metadata.component, bom.metadata.timestamp = own, release.time
    bom.metadata.lifecycles.add(PredefinedLifecycle(LifecyclePhase.BUILD))
    bom.register_dependency(own, [component for component, part in components.items() if part.inside is None])
    for component in components:
        bom.register_dependency(component)
    bom.serial_number = uuid.uuid5(uuid.NAMESPACE_URL, JsonV1Dot6(bom).output_as_string())
    return JsonV1Dot6(bom).output_as_string(indent=2)


def _component(part: Part, internal: Path) -> Component:
    sums = {file.place.replace("\\", "/"): _sum(file, internal) for file in part.files}
    here = [place for place in sums if (internal / place).is_file()] if part.inside is None else []
    reference = part.purl or "@".join(filter(None, (part.inside, part.name, part.version)))
    properties = {
        "dps-s:inside": part.inside,
        "dps-s:note": part.note,
        "dps-s:hash-of": _what_is_hashed(part, list(sums)),
        "dps-s:licence-texts": f"{LICENCES}/{licence_folder(part)}",
    }
    return Component(
        name=part.name, version=part.version,
        bom_ref=reference,
        purl=PackageURL.from_string(part.purl) if part.purl else None,
        hashes=[_hash(_sum_of_all(sums))], licenses=[LicenseFactory().make_from_string(part.licence)],
        properties=_properties(properties),
        components=[
            Component(name=place, type=ComponentType.FILE, bom_ref=f"{reference}#{place}", hashes=[_hash(sums[place])])
            for place in here
        ],
    )  # fmt: skip


def _properties(values: Mapping[str, str | None]) -> Iterable[Property]:
    return [Property(name=name, value=value) for name, value in values.items() if value]


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


def _hash(value: str) -> HashType:
    return HashType(alg=HashAlgorithm.SHA_256, content=value)
