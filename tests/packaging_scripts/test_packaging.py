"""How packages are setup, as far as that can be told without making them (tests/packages makes sure of the rest)."""

import ast
import configparser
import json
import re
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import pytest

from app.__main__ import DEBUG, PORT
from app.cli.commands import ENTRIES
from tests.support.processes import ran_code
from tests.support.setup_files import PACKAGING, ROOT, SetupFiles, registered_endings


def test_the_time_of_a_release_is_given_or_the_commits(setup: SetupFiles, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    found = setup.release.read_release()
    assert found.epoch == 1_700_000_000
    assert f"{found.time:%Y-%m-%d}" == "2023-11-14"
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    assert setup.release.read_release().epoch > 1_700_000_000


# macOS and the forge, which are never run here, and Windows, which only Wine runs.


@pytest.mark.parametrize(
    "path",
    [
        "packaging/macos/disk_image.py",
        ".github/workflows/packages.yml",
    ],
)
def test_what_was_never_run_says_so_first(path: str) -> None:
    first = (ROOT / path).read_text(encoding="utf-8").splitlines()[0]
    assert "Not run here: written for" in first
    assert "never executed" in first


def test_the_types_of_files_are_those_that_the_window_opens() -> None:
    from ui.main import PAGES

    pages = (getattr(import_module(f"ui.pages.{one.key}.page"), f"{one.key.capitalize()}Page") for one in PAGES)
    opened = {suffix for page in pages for suffix in page.suffixes}
    of_older_versions = {".html", ".htm"}  # opened where they are chosen, and no longer written
    assert registered_endings() == opened - of_older_versions


def test_what_is_tried_under_wine_is_there_and_every_exception_has_a_reason(setup: SetupFiles) -> None:
    suites = getattr(setup, "windows.suites")
    tried = {ROOT / name for suite in suites.SUITES for name in suite.tests}
    assert [path for path in tried if not path.exists()] == []
    files = {path for top in ("protocol", "app", "ui") for path in (ROOT / "tests" / top).rglob("test_*.py")}
    assert {path for path in files if not tried & {path, *path.parents}} == set()
    for name, reason in suites.NOT_JUDGED.items():
        path, _, function = name.partition("::")
        tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        assert function in {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}, name
        assert reason


def test_the_uninstaller_takes_nothing_of_the_users() -> None:
    text = (PACKAGING / "windows" / "installer.nsi").read_text(encoding="utf-8")
    taken = re.findall(r"RMDir /r \"([^\"]+)\"", text[text.index('Section "Uninstall"') :])
    assert taken == ["$INSTDIR\\_internal", "$INSTDIR\\licences"]


def test_the_workflow_calls_what_ci_calls() -> None:
    text = (ROOT / ".github/workflows/packages.yml").read_text(encoding="utf-8")
    assert "run: python packaging/bootstrap.py package\n" in text
    assert {"ubuntu", "windows", "macos"} == set(re.findall(r"- system: ([a-z]+)-", text))


# Linux.


def test_the_metadata_names_what_is_installed(setup: SetupFiles) -> None:
    debian = getattr(setup, "linux.debian")
    root = ElementTree.parse(debian.LINUX / debian.METAINFO).getroot()
    assert f"{root.findtext('id')}.metainfo.xml" == debian.METAINFO
    assert root.findtext("launchable") == "dps-s-configurator.desktop"
    assert (debian.LINUX / "dps-s-configurator.desktop").exists()
    entry = configparser.ConfigParser(interpolation=None)
    entry.read(debian.LINUX / "dps-s-configurator.desktop", encoding="utf-8")
    assert entry["Desktop Entry"]["Exec"] == "dps-s %f"
    types = {one.attrib["type"] for one in ElementTree.parse(debian.LINUX / f"{debian.NAME}.xml").getroot()}
    assert set(entry["Desktop Entry"]["MimeType"].rstrip(";").split(";")) == types
    assert {one.text for one in root.iter("mediatype")} == types
    assert entry["Desktop Entry"]["Icon"] == "dps-s-configurator"
    from ui.main import run

    assert 'setDesktopFileName("dps-s-configurator")' in Path(run.__code__.co_filename).read_text(encoding="utf-8")


def test_the_desktop_knows_the_types_of_files(setup: SetupFiles) -> None:
    """By the magic that the file for shared-mime-info names; held against files that the program writes."""
    from app.records.record import FORMAT
    from app.settings.profile_file import profile_text
    from app.settings.profiles import Profile

    debian = getattr(setup, "linux.debian")
    tree = ElementTree.parse(debian.LINUX / f"{debian.NAME}.xml").getroot()
    files = {
        "profile": profile_text(Profile(name="H6", settings={})).encode(),
        "record": json.dumps({"format": FORMAT, "version": 2}, indent=1).encode(),
        "capture": b"# DPS-S capture 1\n",
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
    text = (PACKAGING / "linux" / "dps-s.1").read_text(encoding="utf-8").replace("\\-", "-")
    listed = text[text.index(".SH COMMANDS") : text.index(".SH OPTIONS")].split(".TP\n")[1:]
    assert listed == [f".B {entry.name}\n{entry.summary}\n" for entry in ENTRIES]
    assert {".SH ENVIRONMENT", ".SH FILES", ".SH EXIT STATUS"} <= {*text.splitlines()}
    assert f".B {PORT}" in text
    assert f".B {DEBUG}" in text


# Releases.


def test_a_release_is_refused_while_a_placeholder_is_left(
    setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    release = setup.release
    monkeypatch.setattr(setup.package, "build", lambda: pytest.fail("nothing may be built"))
    assert setup.package.main(["--release"]) == 3
    said = capsys.readouterr().err
    for key, value in release.project().items():
        assert (f"{key} is a placeholder." in said) == ("localhost" in value)
    filled = tmp_path / "pyproject.toml"
    text = release.PYPROJECT.read_text(encoding="utf-8").replace("localhost", "example.org")
    filled.write_text(text, encoding="utf-8")
    monkeypatch.setattr(release, "PYPROJECT", filled)
    newest = release._stated()["tool"]["dps-s"]["oldest-python"]
    assert all(release.refusals((3, int(series.partition(".")[2]), patch)) == [] for series, patch in newest.items())


@pytest.mark.parametrize(
    ("python", "said"),
    [
        ((3, 11, 7), r"Python 3\.11\.7 is too old to be passed on: build with 3\.11\.\d+ or later\."),
        ((3, 10, 99), r"A release brings none of Python 3\.10: .+"),
    ],
)
def test_a_release_is_refused_with_an_old_python(setup: SetupFiles, python: tuple[int, ...], said: str) -> None:
    assert re.fullmatch(said, setup.release.refusals(python)[-1])


def test_who_maintains_it_is_stated_once(setup: SetupFiles) -> None:
    stated = setup.release.project()
    assert {"maintainer", "address", "home_page", "issues", "downloads"} == stated.keys()
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / ".github").rglob("*.*")]
    files = [path for path in (*pages, *(PACKAGING / "linux").iterdir()) if path.is_file()]
    for path in files:
        text = path.read_text(encoding="utf-8")
        assert not [value for key, value in stated.items() if key != "maintainer" and value in text], path
    for page in ("SECURITY.md", "CONTRIBUTING.md"):
        assert "(pyproject.toml)" in (ROOT / page).read_text(encoding="utf-8")


@pytest.mark.parametrize("path", sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.md")), ids=lambda path: path.stem)
def test_issue_templates_have_the_head_that_the_forge_reads(path: Path) -> None:
    _, head, body = path.read_text(encoding="utf-8").split("---\n", 2)
    assert {line.partition(":")[0] for line in head.splitlines()} == {"name", "about"}
    assert "**" in body
    if path.stem == "fault":
        assert "SECURITY.md" in body


def test_the_plots_do_without_what_is_left_out(setup: SetupFiles) -> None:
    """pyqtgraph imports much that it needs for other things, some of it under names that it puts together."""
    left_out = setup.bundle_contents.LEFT_OUT_MODULES
    code = f"import sys; sys.modules.update(dict.fromkeys({left_out!r})); import ui.plots.time_plot"
    done = ran_code(code)
    assert done.returncode == 0, done.stderr
