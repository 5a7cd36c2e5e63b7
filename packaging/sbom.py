"""The list of what a bundle is made of, as CycloneDX 1.6 in JSON, which scanners for known vulnerabilities read."""

import hashlib
import uuid
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.model import HashAlgorithm, HashType, Property
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.model.lifecycle import LifecyclePhase, PredefinedLifecycle
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL
from parts import Part
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
    """With the files that can be seen in the bundle, each with its sum; Python's modules are in the executable."""
    seen = [file.place for file in part.files if (internal / file.place).is_file()]
    reference = part.purl or "@".join(filter(None, (part.inside, part.name, part.version)))
    properties = {
        "dps-s:inside": part.inside,
        "dps-s:inside-files": ", ".join(seen) if part.inside is not None else None,
        "dps-s:note": part.note,
        "dps-s:licence-texts": f"{LICENCES}/{part.folder}",
    }
    return Component(
        name=part.name, version=part.version,
        bom_ref=reference,
        purl=PackageURL.from_string(part.purl) if part.purl else None,
        licenses=[LicenseFactory().make_from_string(part.licence)],
        properties=_properties(properties),
        components=[_file(place, internal, reference) for place in seen] if part.inside is None else [],
    )  # fmt: skip


def _file(place: str, internal: Path, reference: str) -> Component:
    digest = hashlib.sha256((internal / place).read_bytes()).hexdigest()
    return Component(
        name=place, type=ComponentType.FILE, bom_ref=f"{reference}#{place}",
        hashes=[HashType(alg=HashAlgorithm.SHA_256, content=digest)],
    )  # fmt: skip


def _properties(values: Mapping[str, str | None]) -> Iterable[Property]:
    return [Property(name=name, value=value) for name, value in values.items() if value]
