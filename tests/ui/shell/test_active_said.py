"""No text says that the module does not fire, since it may be ACTIVE while the text is shown."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import WAIT_MS, connect, simulated, window
from tests.support.window.spoken import said_by
from ui.main import PAGES

FIRES = r"(?:fires?|deploys?)\b"
REASSURES = re.compile(
    rf"\b(?:does not|do not|will not|won't|cannot|never|nothing can|no longer|not going to) {FIRES}|neither arms"
    r"|\bnothing that can fire|\bnot to fire|(?<!可能)(?:不会|永不|不再|不能|无法)(?:自动|真的)?(?:触发)?(?:开伞|触发)"
    r"|也不开伞",
    re.IGNORECASE,
)
CONDITIONAL = re.compile(r"\bwould not (?:have fired|fire)\b", re.IGNORECASE)
TRANSLATION = Path(__file__).parents[3] / "app" / "locale" / "zh_CN.ts"


@pytest.mark.parametrize(
    "text", ["It does NOT fire in free fall.", "Nothing can fire.", "锁定的模块不会开伞。", "它不再自动开伞。"]
)
def test_such_a_sentence_would_be_found(text: str) -> None:
    assert REASSURES.search(text)


def test_no_text_of_the_program_says_that_a_module_does_not_fire() -> None:
    found = []
    for message in ElementTree.parse(TRANSLATION).getroot().iter("message"):
        source, chinese = message.findtext("source") or "", message.findtext("translation") or ""
        if not CONDITIONAL.search(source):  # of what was measured, not of the module
            found += [text for text in (source, chinese) if REASSURES.search(text)]
    assert not found


def test_no_page_says_so_of_an_active_module(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("active_said", active=True), window(qapp, tmp_path, entries=PAGES) as assembly:
        main = assembly.window
        qtbot.waitUntil(lambda: main.stack.count() == len(PAGES), timeout=WAIT_MS)
        connect(qtbot, assembly, "sim://active_said")
        qtbot.waitUntil(lambda: main.top_bar.activation.word == "ACTIVE", timeout=WAIT_MS)
        for entry in PAGES:
            main.go_to(entry.key)
            main.refresh()
            said = list(said_by(main))
            assert not [one for one in said if REASSURES.search(one.text)], entry.key
            assert not [one for one in said if re.search(r"(?:^|: )LOCKED$", one.text)], entry.key
