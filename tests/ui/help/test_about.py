"""The About box: components and their licences."""

import re

from PySide6.QtWidgets import QWidget
from pytestqt.qtbot import QtBot

from ui.help.small_windows import show_about


def test_every_component_is_listed_with_version_and_licence(qtbot: QtBot) -> None:
    window = QWidget()
    qtbot.addWidget(window)
    box = show_about(window)
    lines = box.informativeText().splitlines()
    parts = lines[lines.index(next(one for one in lines if one.startswith("Python"))) :]
    assert {"numpy", "mcap"} <= {one.split()[0] for one in parts}
    for one in parts:
        assert re.fullmatch(r"\S+ [\d.]+\S* \(.+\)", one), one
    assert "mcap" in parts[-1]
    assert parts[-1].endswith("(MIT)")
    box.close()
