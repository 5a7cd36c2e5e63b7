"""How packages are made, as far as that can be told without making them; tests/system/packages tells the rest."""

import configparser
import json
import re
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import pytest

from app.__main__ import PORT
from app.cli.commands import ENTRIES
from tests.support.setup_files import PACKAGING, ROOT, SetupFiles, registered_endings

LINUX = PACKAGING / "linux"
NAME = "dps-s-configurator"
METAINFO = LINUX / "io.github.dps_s.configurator.metainfo.xml"


@pytest.mark.parametrize("path", sorted((ROOT / ".github" / "workflows").iterdir()), ids=lambda path: path.name)
def test_what_was_never_run_says_so_first(path: Path) -> None:
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert "Not run here: written for GitHub, never executed" in first


def test_the_types_of_files_are_those_that_the_window_opens() -> None:
    from ui.main import PAGES

    pages = (getattr(import_module(f"ui.pages.{one.key}.page"), f"{one.key.capitalize()}Page") for one in PAGES)
    opened = {suffix for page in pages for suffix in page.suffixes}
    opened_where_chosen = {".html", ".htm", ".zip", ".gz"}  # too many files of other programs end so
    assert registered_endings() == opened - opened_where_chosen


def test_the_uninstaller_takes_nothing_of_the_users() -> None:
    text = (PACKAGING / "windows" / "installer.nsi").read_text(encoding="utf-8")
    taken = re.findall(r"RMDir /r \"([^\"]+)\"", text[text.index('Section "Uninstall"') :])
    assert taken == ["$INSTDIR\\_internal", "$INSTDIR\\licences"]


def test_the_metadata_names_what_is_installed() -> None:
    root = ElementTree.parse(METAINFO).getroot()
    assert f"{root.findtext('id')}.metainfo.xml" == METAINFO.name
    assert root.findtext("launchable") == f"{NAME}.desktop"
    assert root.find("screenshots/screenshot/image") is not None
    entry = configparser.ConfigParser(interpolation=None)
    entry.read(LINUX / f"{NAME}.desktop", encoding="utf-8")
    assert entry["Desktop Entry"]["Exec"] == "dps-s %f"
    assert entry["Desktop Entry"]["Icon"] == NAME
    types = {one.attrib["type"] for one in ElementTree.parse(LINUX / f"{NAME}.xml").getroot()}
    assert set(entry["Desktop Entry"]["MimeType"].rstrip(";").split(";")) == types
    assert {one.text for one in root.iter("mediatype")} == types
    from ui.main import run

    assert f'setDesktopFileName("{NAME}")' in Path(run.__code__.co_filename).read_text(encoding="utf-8")


def test_the_desktop_knows_the_types_of_files() -> None:
    """By the magic that the file for shared-mime-info names; held against files that the program writes."""
    from app.records.record import FORMAT
    from app.settings.profiles import Profile, profile_text

    tree = ElementTree.parse(LINUX / f"{NAME}.xml").getroot()
    files = {
        "profile": profile_text(Profile(name="H6", settings={})).encode(),
        "record": json.dumps({"format": FORMAT, "version": 2}, indent=1).encode(),
        "mcap": b"\x89MCAP0\r\n",
        "ulog": b"ULog\x01\x12\x35",
    }
    for kind in tree:
        name = kind.attrib["type"].rpartition(".")[2]
        others = {other for other, content in files.items() if any(_matches(one, content) for one in _magic(kind))}
        assert others == {name}


_NAMESPACE = "{http://www.freedesktop.org/standards/shared-mime-info}"


def _magic(kind: ElementTree.Element) -> list[ElementTree.Element]:
    return kind.findall(f"{_NAMESPACE}magic/{_NAMESPACE}match")


def _matches(rule: ElementTree.Element, content: bytes) -> bool:
    first, _, last = rule.attrib["offset"].partition(":")
    value = rule.attrib["value"].encode().decode("unicode_escape").encode("latin-1")
    found = content.find(value, int(first), int(last or first) + len(value))
    inner = rule.findall(f"{_NAMESPACE}match")
    return found >= 0 and (not inner or any(_matches(one, content) for one in inner))


def test_the_manual_names_every_command() -> None:
    text = (LINUX / "dps-s.1").read_text(encoding="utf-8").replace("\\-", "-")
    listed = text[text.index(".SH COMMANDS") : text.index(".SH OPTIONS")].split(".TP\n")[1:]
    assert listed == [f".B {entry.name}\n{entry.summary}\n" for entry in ENTRIES]
    assert f".B {PORT}" in text


def test_a_release_is_refused_while_a_placeholder_is_left(
    setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    release = setup.release
    monkeypatch.setattr(setup.package, "build", lambda: pytest.fail("nothing may be built"))
    if release.refusals():
        assert setup.package.main(["--release"]) == 3
        assert "homepage is a placeholder." in capsys.readouterr().err
    filled = tmp_path / "pyproject.toml"
    filled.write_text(release.PYPROJECT.read_text(encoding="utf-8").replace("localhost", "example.org"), "utf-8")
    monkeypatch.setattr(release, "PYPROJECT", filled)
    assert release.refusals() == []


def test_who_maintains_it_is_stated_once(setup: SetupFiles) -> None:
    told = setup.release.words()
    stated = [told["MAINTAINER"].partition("<")[2].rstrip(">"), told["HOMEPAGE"]]
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / ".github").rglob("*.*")]
    files = [path for path in (*pages, *LINUX.iterdir()) if path.is_file()]
    assert [path for path in files if any(one in path.read_text(encoding="utf-8") for one in stated)] == []
    for page in ("SECURITY.md", "CONTRIBUTING.md"):
        assert "(pyproject.toml)" in (ROOT / page).read_text(encoding="utf-8")
