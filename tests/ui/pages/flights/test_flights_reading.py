"""Reading logs that never end, or take long."""

import threading
from collections.abc import Iterator
from math import inf, nan
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.flights.many_logs import SummarisedLog
from app.flights.summary import FirstFire, summarise
from protocol.messages import Source
from tests.support.flights.made_flights import write_csv, write_logs
from tests.support.window.steps import press
from tests.ui.pages.flights.test_flights_page import MUST, MUST_NOT, UNSORTED, Desk, desk, opened, tilted
from ui.pages.flights import controller, lists

__all__ = ["desk"]


@pytest.mark.parametrize(
    ("fire", "said"),
    [
        (FirstFire(inf, Source(0), False, nan, nan), "No trigger"),
        (FirstFire(3.0, Source.ATTITUDE, True, nan, nan), "Fires at 3.0 s: attitude"),
        (
            FirstFire(3.0, Source.ATTITUDE | Source.FREEFALL, True, 0.5, 2.0),
            "Fires at 3.0 s: attitude · free fall, 0.50 s after the loss of control, 2 m lower",
        ),
        (FirstFire(3.0, Source.FREEFALL, False, 0.5, 2.0), "Fires at 3.0 s: free fall, after the impact"),
    ],
)
def test_only_the_triggers_that_fire_are_named(fire: FirstFire, said: str) -> None:
    assert lists.fire_text(fire) == said


def test_cancel_is_immediate_and_late_results_change_nothing(
    desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reading blocks in the middle of a log and ignores a cancellation."""
    may_end, has_begun, has_ended = threading.Event(), threading.Event(), threading.Event()
    paths = [write_csv(tmp_path / f"{number}.csv", tilted("", 20)) for number in range(3)]

    def slowly(logs: list[Path], _order: object, **_told: object) -> Iterator[SummarisedLog]:
        yield SummarisedLog(logs[0], summarise(tilted(str(logs[0]), 20)))
        has_begun.set()
        assert may_end.wait(30)
        yield SummarisedLog(logs[1], summarise(tilted(str(logs[1]), 20)))
        has_ended.set()

    monkeypatch.setattr(controller, "summarise_logs", slowly)
    desk.page.open_paths(paths)
    assert has_begun.wait(30)
    desk.qtbot.waitUntil(lambda: desk.notice() == "Reading logs… (1 of 3)")
    desk.page.open_paths([write_csv(tmp_path / "waits.csv", tilted("", 20))])
    press(desk.qtbot, desk.page.strip.button("cancel_flights"))  # without waiting
    assert desk.notice() == "Cancelled. 1 of 3 logs"
    assert desk.shown(UNSORTED) == [str(paths[0])]
    may_end.set()
    assert has_ended.wait(30)
    QApplication.processEvents()
    desk.page.work.poll()
    assert desk.shown(UNSORTED) == [str(paths[0])]


def test_a_wrong_line_of_columns_is_said(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as desk:
        write_logs(tmp_path / "logs")
        desk.page.open_paths([tmp_path / "logs"])
        desk.wait_read()
        press(qtbot, desk.page.strip.button("columns"))
        form = desk.page.form
        form.line.setText("time_s=w time_ms=w")
        form.read.click()
        assert form.fault.text() == "Choose one column for “time”."


def test_a_log_that_is_gone_is_said(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as desk:
        path = write_csv(tmp_path / "gone.csv", tilted("", 20))
        desk.page.open_paths([path])
        desk.wait_read()
        path.unlink()
        desk.page.open_flight(desk.page.lists.of[UNSORTED].table.filter.row_at(0))
        waiting = desk.page.flight.chart.waiting
        qtbot.waitUntil(lambda: "No such file" in waiting.text())
        assert waiting.text().startswith("gone.csv: ")


def test_lists_and_their_flights_are_there_at_the_next_start(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Also a flight that was not read yet when the program ended."""
    paths = [write_csv(tmp_path / f"{name}.csv", tilted("tilt_deg", 20)) for name in ("a", "b", "c")]
    with opened(qtbot, qapp, tmp_path) as desk:
        desk.page.open_paths(paths)
        desk.wait_read()
        desk.page.work.move([str(paths[0])], MUST_NOT)
        desk.page.work.move([str(paths[1])], MUST)
        desk.page.work.remove([str(paths[2])])
    with opened(qtbot, qapp, tmp_path) as desk:
        desk.page.work.cancel()  # before they are read
    for _ in range(2):
        with opened(qtbot, qapp, tmp_path) as desk:
            desk.wait_read()
            listed = [[flight.name for flight in flights] for flights in desk.page.work.sorted_flights()]
            assert listed == [[str(paths[0])], [str(paths[1])]]


def test_of_flights_that_are_gone_nothing_is_proposed(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    may_end, has_ended = threading.Event(), threading.Event()

    def slowly(*_flights: object) -> str:
        assert may_end.wait(30)
        has_ended.set()
        return "a proposal"

    monkeypatch.setattr(controller, "propose", slowly)
    work = desk.page.work
    work.flights["a"] = controller.Flight("a", summary=summarise(tilted("a", 20)))
    work.move(["a"], MUST)
    work.remove(["a"])
    may_end.set()
    assert has_ended.wait(30)
    desk.qtbot.wait(50)
    assert work.proposal is None
