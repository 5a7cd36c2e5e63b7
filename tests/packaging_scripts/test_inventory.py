"""Whose work is in a bundle, and the list that says so."""

import hashlib
import json
import re
from importlib.metadata import Distribution, version
from pathlib import Path
from typing import Any

import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from license_expression import get_spdx_licensing

from tests.support.setup_files import SetupFiles


def part(setup: SetupFiles, name: str, licence: str, *, files: tuple[Any, ...] = (), **more: Any) -> Any:
    values = {"version": "1", "purl": f"pkg:pypi/{name}@1", "texts": (), **more}
    return setup.inventory.Part(name=name, licence=licence, files=files, **values)


def test_the_list_is_valid_and_has_licence_and_files_of_every_part(setup: SetupFiles, tmp_path: Path) -> None:
    entry = setup.bundle_contents.Entry
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib/one.so").write_bytes(b"as it is shipped")
    files = (entry("lib/one.so", "/built/one.so", "BINARY"), entry("two", "/built/two.py", "PYMODULE"))
    found = [
        part(setup, "one", "MIT", files=files[:1]),
        part(setup, "two", "MIT AND Zlib", files=files[1:]),
        part(setup, "three", "LicenseRef-Own", files=files[:1], purl=None, version=None, inside="one", note="old"),
    ]
    release = setup.release.Release("1.2.3", 1_700_000_000)
    text = setup.sbom.bill_of_materials(release, found, tmp_path)
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text) is None
    bill = json.loads(text)
    assert bill["metadata"]["timestamp"] == "2023-11-14T22:13:20+00:00"
    one, three, two = bill["components"]
    assert [file["name"] for file in one["components"]] == ["lib/one.so"]
    assert one["components"][0]["hashes"][0]["content"] == hashlib.sha256(b"as it is shipped").hexdigest()
    assert "components" not in two
    assert [component["licenses"] for component in (one, two, three)] == [
        [{"license": {"id": "MIT"}}],
        [{"expression": "MIT AND Zlib"}],
        [{"license": {"name": "LicenseRef-Own"}}],
    ]
    properties = {one["name"]: one["value"] for one in three["properties"]}
    assert (properties["dps-s:inside"], properties["dps-s:inside-files"]) == ("one", "lib/one.so")
    assert len({one["bom-ref"] for one in bill["components"]}) == 3
    assert setup.sbom.bill_of_materials(release, found, tmp_path) == text


def test_a_part_without_a_licence_text_stops_the_build(
    setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    inventory = setup.inventory
    monkeypatch.setattr(inventory, "_python", lambda files: part(setup, "nameless", "MIT"))
    with pytest.raises(setup.environment.SetupError, match="The licence text of nameless"):
        inventory.parts([], tmp_path)


def test_texts_that_the_inventory_names_are_there(setup: SetupFiles) -> None:
    inventory, enclosed = setup.inventory, setup.enclosed_parts
    paths = [inventory.LICENCE_FOLDER / name for names in inventory.TEXTS.values() for name in names]
    named = [*enclosed.CRATES.values(), *(text for library in enclosed.LIBRARIES for text in library.texts)]
    for path in (*paths, *map(enclosed.text, named)):
        assert path.stat().st_size > 500, path


def notices(setup: SetupFiles) -> tuple[str, list[dict[str, Any]]]:
    listed = json.loads((setup.enclosed_parts.QT_NOTICES / "parts.json").read_text(encoding="utf-8"))
    return listed["documentation"], listed["parts"]


def test_the_notices_are_of_the_series_of_qt_that_is_installed(setup: SetupFiles) -> None:
    """A newer series has other third-party parts: docs/generate/qt_notices.py writes its notices."""
    documentation, listed = notices(setup)
    assert documentation.split(".")[:2] == version("PySide6_Essentials").split(".")[:2]
    assert {"FreeType", "HarfBuzz", "libpng", "PCRE2", "zlib"} <= {
        word for word in ("FreeType", "HarfBuzz", "libpng", "PCRE2", "zlib")
        if any(word.lower() in one["name"].lower() for one in listed)
    }  # fmt: skip
    texts = {path.name for path in setup.enclosed_parts.QT_NOTICES.glob("*.txt")}
    assert texts == {one["file"] for one in listed}
    for name in texts:
        text = (setup.enclosed_parts.QT_NOTICES / name).read_text(encoding="utf-8")
        assert len(text) > 400, name
        assert re.search(r"copyright|public domain|©|written by", text, re.IGNORECASE), name


def test_every_licence_is_an_spdx_expression(setup: SetupFiles) -> None:
    inventory, enclosed = setup.inventory, setup.enclosed_parts
    stated = {one["licence"] for one in notices(setup)[1]} | {library.licence for library in enclosed.LIBRARIES}
    stated |= {*inventory.LICENCES.values(), *inventory.OF_THE_SYSTEM.values()}
    spdx, plain = get_spdx_licensing(), {re.sub(r"LicenseRef-[\w.-]+", "MIT", one) for one in stated}
    assert {one: found for one in plain if (found := spdx.validate(one).errors)} == {}


@pytest.mark.parametrize(
    ("system", "file", "holds", "lacks"),
    [
        ("linux", "PySide6/Qt/lib/libQt6Gui.so.6", {"HarfBuzz-NG", "XCB-XInput"}, {"Freetype 2", "PCRE2"}),
        ("win32", "PySide6/Qt6Gui.dll", {"HarfBuzz-NG", "Freetype 2", "D3D12 Memory Allocator"}, {"XCB-XInput"}),
        ("darwin", "PySide6/Qt/lib/QtCore.framework/Versions/A/QtCore", {"PCRE2", "QEventDispatcher on macOS"}, set()),
        ("linux", "PySide6/QtGui.abi3.so", set(), {"HarfBuzz-NG"}),
    ],
)
def test_what_is_built_into_qt_depends_on_system_and_library(
    setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, tmp_path: Path,
    system: str, file: str, holds: set[str], lacks: set[str],
) -> None:  # fmt: skip
    source = tmp_path / "library"
    source.write_bytes(b"...\0libpng version 9.8.7\0")
    monkeypatch.setattr("sys.platform", system)
    entry = setup.bundle_contents.Entry(file, str(source), "BINARY")
    found = {enclosed_part.name: enclosed_part for enclosed_part in setup.enclosed_parts.enclosed_parts([entry])}
    assert holds <= found.keys()
    assert not lacks & found.keys()
    if "LibPNG" in found:
        assert (found["LibPNG"].version, found["LibPNG"].note) == ("9.8.7", None)


def test_a_distribution_that_states_no_licence_is_named_by_us_or_stops_the_build(
    setup: SetupFiles, tmp_path: Path
) -> None:
    """The numpy for Windows states none in a form that can be read."""
    inventory = setup.inventory
    for name in ("numpy", "nameless"):
        folder = tmp_path / f"{name}-1.0.dist-info"
        folder.mkdir()
        (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", encoding="utf-8")
        (folder / "RECORD").touch()
    numpy, nameless = (Distribution.at(tmp_path / f"{name}-1.0.dist-info") for name in ("numpy", "nameless"))
    assert "BSD-3-Clause" in inventory._from_distribution(numpy, ()).licence
    with pytest.raises(setup.environment.SetupError, match="nameless states no licence"):
        inventory._from_distribution(nameless, ())


def test_the_crates_of_cryptography_are_listed_with_their_texts(setup: SetupFiles) -> None:
    entry = setup.bundle_contents.Entry("cryptography/hazmat/bindings/_rust.pyd", "_rust.pyd", "EXTENSION")
    found = {
        (enclosed_part.name, enclosed_part.folder): enclosed_part
        for enclosed_part in setup.enclosed_parts.enclosed_parts([entry])
    }
    inside = "inside-cryptography"
    assert {("openssl", f"{inside}/openssl"), ("openssl", f"{inside}/crate-openssl")} <= found.keys()
    assert {"asn1", "pem", "pyo3"} <= {name for name, _ in found}
    for one in found.values():
        assert one.texts, f"{one.name}: {one.licence}"


def test_every_library_that_psycopg_brings_is_named(setup: SetupFiles, tmp_path: Path) -> None:
    enclosed, entry = setup.enclosed_parts, setup.bundle_contents.Entry

    def named(*places: str) -> dict[str, str | None]:
        entries = [entry(place, str(tmp_path / "library"), "BINARY") for place in places]
        return {enclosed_part.name: enclosed_part.version for enclosed_part in enclosed.enclosed_parts(entries)}

    (tmp_path / "library").write_bytes(b"OpenSSL 3.6.5 29 Sep 2026\0keyutils-1.5.8")
    names = ("libcrypto-3-x64-cf63.dll", "libpq-f339.dll", "libssl-3-x64-4e7c.dll")
    assert named(*(f"psycopg_binary.libs/{name}" for name in names)) == {"libpq": None, "OpenSSL": "3.6.5"}
    brought = Distribution.from_name("psycopg-binary").files or ()
    found = named(*(file.as_posix() for file in brought if ".libs/" in file.as_posix()))
    assert {"libpq", "OpenSSL"} <= found.keys()
    assert named("libssl.so.3") == {}
    with pytest.raises(setup.environment.SetupError, match="libnew"):
        named("psycopg_binary.libs/libnew-1.so.2")
