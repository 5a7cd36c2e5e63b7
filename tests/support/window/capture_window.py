"""Writes a capture file, and opens it in a window."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PySide6.QtWidgets import QApplication, QPushButton
from pytestqt.qtbot import QtBot

from app.captures.entries import CaptureEntry, Way
from app.recordings.session_format import Opening
from protocol.catalogue import BY_NAME
from protocol.messages import Status
from tests.support.records.recordings_made import NOON
from tests.support.records.written_sessions import write_session
from tests.support.window.steps import choosing, given, press
from tests.ui.pages.diagnosis.test_diagnosis_page import diagnosis
from ui.main import Assembly
from ui.pages.diagnosis.files import SUFFIX
from ui.pages.diagnosis.page import DiagnosisPage

ACTIVE = Status(7, 1.0, triggered=False, active=True).encode()


def write_capture(path: Path, *, seconds: float = 30.0) -> Path:
    """Write a capture of an ACTIVE module that answers the first queries and then streams."""
    entries = []
    for number, name in enumerate(("heartbeat", "status", "active", "triggered", "cell_voltage", "boot_count")):
        request = BY_NAME[name].query()
        entries.append(CaptureEntry(0.01 * number, Way.OUT, request.encode()))
    answers = {"heartbeat": "4175 01 A5 5A 00", "active": "4175 33 01 01 35", "cell_voltage": "4175 34 01 BE F3"}
    ordered = []
    for entry, name in zip(entries, ("heartbeat", "status", "active", "triggered", "cell_voltage", "x"), strict=True):
        ordered.append(entry)
        if name in answers:
            ordered.append(CaptureEntry(entry.at_s + 0.002, Way.IN, bytes.fromhex(answers[name])))
    ordered += [CaptureEntry(0.2 + 0.05 * n, Way.IN, ACTIVE) for n in range(round(seconds * 20))]
    ordered.append(CaptureEntry(ordered[-1].at_s + 0.01, Way.IN, b"\x00\xff"))
    opening = Opening(started_at=NOON, start_s=0.0, port="/dev/ttyUSB0", baud_rate=115200)
    write_session(path, opening, ordered)
    return path


@contextmanager
def opened(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[tuple[Assembly, DiagnosisPage, Path]]:
    path = write_capture(folder / f"flight{SUFFIX}")
    with diagnosis(qtbot, qapp, folder) as (assembly, page):
        page.files.ask_open = choosing(path)
        press(qtbot, page.files.open)
        qtbot.waitUntil(lambda: page.opened is not None)
        yield assembly, page, path


def strip_button(page: DiagnosisPage, key: str) -> QPushButton:
    return given(page.strip.button(key))
