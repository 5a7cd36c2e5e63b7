"""docs/protocol.md is current and complete, and its check finds errors."""

import re
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

from protocol.catalogue import COMMANDS
from protocol.frame import Frame
from protocol.stream import StreamParser
from tests.support.line.vectors import VECTORS

ROOT = Path(__file__).parents[2]
FRAME = re.compile(r"`((?:41 75|42 61)(?: [0-9A-F]{2})+)`")


@pytest.fixture(scope="module")
def protocol_page() -> ModuleType:
    """Loads the tool from its file, because docs/ is not a package."""
    spec = spec_from_file_location("dps_s_protocol_page", ROOT / "docs" / "generate" / "protocol_page.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [*sys.path])
        spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def text() -> str:
    return (ROOT / "docs" / "protocol.md").read_text(encoding="utf-8")


def test_the_page_is_current(protocol_page: ModuleType) -> None:
    assert protocol_page.main(["--check"]) == 0, "run python docs/generate/protocol_page.py"


def test_a_page_that_is_out_of_date_is_noticed_and_written_again(
    protocol_page: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    stale = tmp_path / "docs" / "protocol.md"
    monkeypatch.setattr(protocol_page, "PAGE", stale)
    assert protocol_page.main(["--check"]) == 1
    assert not stale.exists()
    assert protocol_page.main([]) == 0
    assert protocol_page.main(["--check"]) == 0
    stale.write_text(stale.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert protocol_page.main(["--check"]) == 1
    assert "out of date" in capsys.readouterr().err


def test_every_command_and_every_contradiction_is_on_the_page(text: str) -> None:
    for command in COMMANDS:
        assert f"| {command.code:02X} | `{command.name}` | {command.vendor_term} |" in text
    assert re.findall(r"^\| (E\d+) \|", text, re.MULTILINE) == [f"E{number}" for number in range(1, 16)]


def test_every_contradiction_has_a_test_named_after_it() -> None:
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("test_*.py"))
    assert [number for number in range(1, 16) if f"def test_e{number:02}_" not in sources] == []


def test_every_frame_on_the_page_is_one(text: str) -> None:
    printed = {bytes.fromhex(found) for found in FRAME.findall(text)}
    assert len(printed) > 40
    misprint = bytes.fromhex("41 75 20 01 3C 50")
    for raw in printed - {misprint}:
        parser = StreamParser()
        (piece,) = parser.feed(raw) + parser.flush()
        assert isinstance(piece, Frame), piece


def test_every_frame_of_the_table_is_on_the_page_or_differs_in_its_value(text: str) -> None:
    printed = {bytes.fromhex(found)[:3] for found in FRAME.findall(text)}
    assert {vector.raw[:3] for vector in VECTORS} <= printed
