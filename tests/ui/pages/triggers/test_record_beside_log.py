"""A trigger record beside a flight log: proposed moments, what a person confirms, and what cannot be matched."""

import threading
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication

from app.records.trigger_filing import PossiblyOther
from app.trigger_records.history import Judgement
from tests.support.flights.made_flights import made_flight, write_csv
from tests.support.patience import PATIENCE_S
from tests.support.window.fakes_ui import store_of
from tests.support.window.preflight_window import OnBench, name_module
from tests.support.window.steps import given, notice_text
from ui.files.file_dialogs import ThenPath
from ui.pages.triggers.page import RecordBesideLog

ATTITUDE = bytes.fromhex("01 00 6C 02 3C 05 A0 00 01 03 C8".replace(" ", ""))
"""D4 to D14: boot 1, 108 s, attitude, 60°, 0.5 g, 1.6 s."""
SERIAL = ATTITUDE[:3] + b"\x01" + ATTITUDE[4:]


def log_with(path: Path, *tilts_deg: float) -> Path:
    """Ten level seconds before each second of tilt, and after the last."""
    pieces = [np.concatenate([np.full(500, 3.0), np.full(50, tilt)]) for tilt in tilts_deg]
    return write_csv(path, made_flight(np.concatenate([*pieces, np.full(500, 3.0)]), 1.0))


def opened(bench: OnBench, data: bytes, log: Path) -> RecordBesideLog:
    bench.bench.module.memory.records.append(data)
    name_module(bench, "M-07", "triggers")
    bench.read_triggers()
    bench.until(lambda: not bench.triggers.work.is_busy)
    page = bench.triggers
    page.ask_log = lambda _parent, _folder, then: then(log)
    page.detail.beside.click()
    bench.qtbot.waitUntil(lambda: page.beside.match is not None or "gone" in page.beside.chart.waiting.text())
    assert page.beside.isVisible()
    return page.beside


def stored(bench: OnBench) -> tuple[Judgement | None, str]:
    bench.until(lambda: not bench.triggers.work._judging)
    (row,) = bench.triggers.work.rows
    return row.seen.judgement, row.seen.note


def test_a_moment_is_proposed_shown_and_confirmed(rig: OnBench, tmp_path: Path) -> None:
    beside = opened(rig, ATTITUDE, log_with(tmp_path / "crash.csv", 75))
    assert beside.name.text() == "Trigger record beside crash.csv"
    assert beside.record.text().startswith("Tipped past 60")
    assert beside.explanation.text().startswith("Proposal: at 10.0 s the log shows 75°.")
    assert "powered on at -98 s of the log" in beside.explanation.text()
    plot = given(beside.chart.plot)
    assert plot.time_range.cursor_s == pytest.approx(10.0, abs=0.05)
    assert not beside.moments.isVisible()  # there is one only
    rig.assembly.appearance.zoom(200)
    assert not beside.chart.isVisible()
    assert beside.explanation.text().endswith("A higher window also shows: Plots")
    rig.assembly.appearance.zoom(100)
    assert beside.chart.isVisible()
    assert stored(rig) == (None, "")  # a proposal is none of the record
    beside.buttons[Judgement.REAL].click()
    assert stored(rig) == (Judgement.REAL, "crash.csv at 10.0 s: 75°")
    assert rig.triggers.table.isVisible()
    assert rig.acts == []


def test_one_of_several_moments_is_chosen_and_the_note_of_before_is_kept(rig: OnBench, tmp_path: Path) -> None:
    log = log_with(tmp_path / "two.csv", 75, 90)
    beside = opened(rig, ATTITUDE, log)
    assert [beside.moments.itemText(row) for row in range(2)] == ["10.0 s · 75°", "21.0 s · 90°"]
    assert "Moments that match: 2." in beside.explanation.text()
    (row,) = rig.triggers.work.rows
    rig.triggers.work.judge(row.seen.id, Judgement.REVIEWED, "seen by Ann")
    beside.moments.setCurrentIndex(1)
    assert beside.explanation.text().startswith("Proposal: at 21.0 s the log shows 90°.")
    beside.buttons[Judgement.FALSE].click()
    noted = "two.csv at 21.0 s: 90° · seen by Ann"
    assert stored(rig) == (Judgement.FALSE, noted)
    (row,) = rig.triggers.work.rows
    rig.triggers.open_beside(row, log)
    rig.qtbot.waitUntil(lambda: beside.match is not None)
    beside.moments.setCurrentIndex(1)
    beside.buttons[Judgement.FALSE].click()
    assert stored(rig) == (Judgement.FALSE, noted)  # not twice


@pytest.mark.parametrize(("data", "tilt", "why"), [
    (ATTITUDE, 40, "No moment of this log matches: tilt at most 40°."),
    (SERIAL, 75, "No flight log shows this cause: fired by serial."),
])  # fmt: skip
def test_without_a_moment_there_is_nothing_to_confirm(
    rig: OnBench, tmp_path: Path, data: bytes, tilt: float, why: str
) -> None:
    beside = opened(rig, data, log_with(tmp_path / "calm.csv", tilt))
    assert beside.explanation.text() == why
    assert beside.chart.plot is not None  # to look for oneself
    assert not any(button.isVisible() for button in beside.buttons.values())
    assert rig.triggers.on_escape()
    assert rig.triggers.table.isVisible()
    assert stored(rig) == (None, "")


def test_a_log_that_cannot_be_read_says_why(rig: OnBench, tmp_path: Path) -> None:
    beside = opened(rig, ATTITUDE, tmp_path / "gone.ulg")
    assert beside.chart.waiting.text() == "gone.ulg: No such file or directory."
    assert beside.explanation.text() == ""


def test_the_log_is_left_when_another_module_is_shown(rig: OnBench, tmp_path: Path) -> None:
    beside = opened(rig, ATTITUDE, log_with(tmp_path / "crash.csv", 75))
    name_module(rig, "M-08", "triggers")
    rig.until(lambda: beside.row is None)
    assert rig.triggers._records.isVisible()


def test_a_record_that_is_not_kept_cannot_be_confirmed(rig: OnBench) -> None:
    rig.bench.module.memory.records.append(ATTITUDE)
    rig.read_triggers()
    assert rig.triggers.detail.beside.isVisible()
    assert not rig.triggers.detail.beside.isEnabled()


def test_it_follows_the_language(rig: OnBench, tmp_path: Path) -> None:
    beside = opened(rig, ATTITUDE, log_with(tmp_path / "two.csv", 75, 90))
    beside.moments.setCurrentIndex(1)
    rig.assembly.language_switch.use("zh_CN")
    assert "21.0 s" in beside.explanation.text()
    assert "Proposal" not in beside.explanation.text()
    assert beside.moments.currentIndex() == 1


def test_a_log_chosen_after_another_module_has_come_is_not_opened(rig: OnBench, tmp_path: Path) -> None:
    log, page = log_with(tmp_path / "crash.csv", 75), rig.triggers
    rig.bench.module.memory.records.append(ATTITUDE)
    name_module(rig, "M-07", "triggers")
    rig.read_triggers()
    rig.until(lambda: not page.work.is_busy)
    asked: list[ThenPath] = []
    page.ask_log = lambda _parent, _folder, then: asked.append(then)
    page.detail.beside.click()
    rig.assembly.connector.current.module.treat_as_new()
    asked[0](log)
    assert page.beside.row is None
    assert not page.beside.isVisible()
    assert notice_text(page.strip) == "Another module is shown now: nothing was opened."


def test_records_of_another_module_that_was_there_for_a_while_are_not_kept_under_the_name(rig: OnBench) -> None:
    """It was pulled out again before the link counted as lost, and the person says that the right one is back."""
    port, page, memory = rig.assembly.connector.current, rig.triggers, rig.bench.module.memory
    name_module(rig, "M-07", "triggers")
    rig.until(lambda: port.identity.is_named)
    for records in ([ATTITUDE], []):
        breaks = port.device.breaks
        rig.bench.change(mute=True)
        rig.until(lambda breaks=breaks: port.device.breaks > breaks)  # type: ignore[misc]
        memory.records.clear()
        memory.records.extend(records)
        rig.bench.change(mute=False)
        rig.until(lambda: port.identity.is_for_a_person and not page.work.is_busy)
        if records:
            rig.read_triggers()
            assert len(page.work.rows) == 1
    port.module.confirm_identity()
    rig.until(lambda: port.module.name == "M-07" and not page.work.is_busy)
    assert page.work.rows == ()


def test_a_module_that_is_gone_is_not_asked_about(rig: OnBench, monkeypatch: pytest.MonkeyPatch) -> None:
    """The question came while the next one was shown, and its answer kept that one's records under the name."""
    release, page, store = threading.Event(), rig.triggers, store_of(rig.assembly.storage)

    def file_slowly(*_of: object, **_more: object) -> PossiblyOther:
        release.wait(PATIENCE_S)
        return PossiblyOther()

    name_module(rig, "M-07", "triggers")
    rig.until(lambda: not page.work.is_busy)
    monkeypatch.setattr("ui.pages.triggers.controller.file_triggers", file_slowly)
    rig.beside_s = 0.05
    page.work.read()
    rig.until(lambda: page.work._filing.is_running)
    rig.assembly.connector.current.module.treat_as_new()
    release.set()
    store.queue.submit(lambda: None).result(PATIENCE_S)
    QApplication.processEvents()
    assert "do not follow" not in notice_text(page.strip)
