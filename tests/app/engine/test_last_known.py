"""A lost ACTIVE stays in sight as "was ACTIVE"; a shut-down by command is no fault."""

from collections.abc import Iterator
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase, link_state, link_text
from app.engine.device import Device, DeviceView, How, Known, StaleReason
from app.engine.motion import WATCHED_FOR_S, MotionExtremes, MotionWatch
from app.engine.worker import Connection, PortState
from app.procedures.handshake import Silence
from app.safety.acts import Act
from app.safety.last_known import Activation, LastKnown
from protocol.catalogue import STATUS
from protocol.events import Received, Role
from protocol.frame import Direction, Frame, encode_long
from protocol.link_states import Presence
from protocol.messages import Status, decode
from tests.support.window.painted_text import watching
from tests.support.window.settings_bench import desk
from ui.shell.attention import link_notice
from ui.style.appearance import Appearance
from ui.style.theme import Choice, Meaning, current
from ui.widgets.readout import StateChip, show_activation

NOW = 100.0


def view(value: bool | None, **how: Any) -> DeviceView:
    known = {} if value is None else {"active": Known(value, how.get("how", How.READ), NOW, how.get("stale_reason"))}
    return DeviceView(MappingProxyType(known), Presence.ONLINE, NOW)


@pytest.mark.parametrize("stale_reason", list(StaleReason))
@pytest.mark.promise("l")
def test_a_lost_active_is_said_as_was_active(stale_reason: StaleReason) -> None:
    last = LastKnown()
    last.feed(view(True))
    assert last.activation(view(True), NOW).state is Activation.ACTIVE
    seen = last.activation(view(True, stale_reason=stale_reason), NOW + 30)
    assert (seen.state, seen.at, seen.may_fire) == (Activation.WAS_ACTIVE, NOW, True)


def test_the_port_came_back_and_nothing_is_answered_yet() -> None:
    last = LastKnown()
    last.feed(view(True))
    last.feed(view(None))
    assert last.activation(view(None), NOW + 30).state is Activation.WAS_ACTIVE
    last.clear()  # another adapter
    assert last.activation(view(None), NOW + 30).state is Activation.UNKNOWN


@pytest.mark.promise("l")
def test_only_a_report_ends_it() -> None:
    last = LastKnown()
    last.feed(view(True))
    acknowledged = view(True, stale_reason=StaleReason.WRITE_UNCONFIRMED)  # LOCK
    last.feed(acknowledged)
    assert last.activation(acknowledged, NOW + 5).state is Activation.WAS_ACTIVE
    reported = view(False)
    last.feed(reported)
    assert last.activation(reported, NOW).state is Activation.LOCKED
    assert last.activation(view(False, stale_reason=StaleReason.LINK_LOST), NOW + 5).state is Activation.WAS_LOCKED
    assert last.activation(view(None), NOW + 5).state is Activation.UNKNOWN


def test_an_activation_that_nobody_answered_is_not_called_locked() -> None:
    last = LastKnown()
    unanswered = view(False, stale_reason=StaleReason.WRITE_UNCONFIRMED)
    last.feed(unanswered)
    assert last.activation(unanswered, NOW).state is Activation.UNKNOWN


@pytest.fixture
def chip(qtbot: QtBot, qapp: QApplication) -> Iterator[StateChip]:
    appearance = Appearance(qapp, Choice.LIGHT)
    one = StateChip("Activation")
    qtbot.addWidget(one)
    yield one
    appearance.choose(Choice.LIGHT)


def test_the_chip_of_a_lost_active_is_amber_and_hatched(chip: StateChip) -> None:
    last = LastKnown()
    last.feed(view(True))
    show_activation(chip, last.activation(view(None), NOW + 12), NOW + 12)
    chip.resize(chip.sizeHint())
    with watching() as drawn:
        picture = chip.grab().toImage()
    assert [one.text for one in drawn] == ["was ACTIVE · 12 s ago"]
    assert chip.meaning is Meaning.ATTENTION
    assert chip.accessibleName() == "Activation: was ACTIVE, 12 s ago"
    amber = current().ink(Meaning.ATTENTION).rgb()
    right_edge = [picture.pixel(x, y) for x in range(picture.width() - 8, picture.width()) for y in range(4, 26)]
    assert amber in right_edge  # dashes and diagonals
    assert right_edge.count(amber) < len(right_edge) / 2  # and is not filled, as one that is reported now


OPEN = Connection(PortState.OPEN, "/dev/ttyUSB0", 115200)


def offline(last: LastKnown, device: DeviceView, silence: Silence | None = None) -> Any:
    return link_state(OPEN, device, silence, is_finding=False, switched_off_at=last.switched_off_at)


def test_a_shut_down_by_command_is_calm_until_it_answers() -> None:
    last, silent = LastKnown(), DeviceView(view(False).values, Presence.OFFLINE, NOW + 2)
    last.feed(silent)
    assert offline(last, silent).phase is Phase.OFFLINE
    last.note_shutdown(NOW + 2, 1_700_000_000.0)
    last.feed(DeviceView({"active": Known(False, How.READ, NOW + 2)}, Presence.OFFLINE, NOW + 2))  # its answer
    last.feed(silent)
    state = offline(last, silent)
    said = link_text(state, NOW + 60)
    notice = link_notice(state, NOW + 60, {})
    assert state.phase is Phase.SWITCHED_OFF
    assert said.what.startswith("Switched off at ")
    assert notice is not None
    assert notice.meaning is Meaning.INFORMATION
    assert "answers" not in notice.text
    assert not notice.choices
    back = DeviceView({"active": Known(False, How.READ, NOW + 90)}, Presence.ONLINE, NOW + 90)
    last.feed(back)
    assert offline(last, back).phase is Phase.ONLINE
    gone = DeviceView(back.values, Presence.OFFLINE, NOW + 99)
    assert offline(last, gone).phase is Phase.OFFLINE  # this silence was not ordered


def test_a_module_that_answers_after_all_is_never_called_switched_off() -> None:
    last = LastKnown()
    last.note_shutdown(NOW + 2, 1_700_000_000.0)
    assert offline(last, view(False)).phase is Phase.ONLINE


def test_the_shut_down_of_one_module_is_not_that_of_another() -> None:
    last, nothing = LastKnown(), DeviceView()
    last.feed(nothing)
    last.note_shutdown(NOW, 1_700_000_000.0)
    assert offline(last, nothing, Silence.GARBAGE).phase is Phase.SILENT  # somebody speaks, at another rate
    assert offline(last, nothing).phase is Phase.SWITCHED_OFF
    last.clear()
    assert offline(last, nothing).phase is Phase.ASKING


def test_shut_down_by_its_button_it_is_told_calmly(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "commands") as one:
        row = one.commands.acts[Act.SHUTDOWN]
        one.until(row.confirm.ask.isEnabled)
        one.click(row.confirm.ask)
        one.until(row.confirm.go.isVisible)
        one.click(row.confirm.go)
        one.until(lambda: one.assembly.ports.current.state.phase is Phase.SWITCHED_OFF, 15_000)
        notice = one.assembly.window.notice_bar
        one.until(lambda: notice.notice is not None)
        assert notice.notice is not None
        assert notice.notice.meaning is Meaning.INFORMATION
        assert one.assembly.window.top_bar.port.word.text().startswith("Switched off at ")
        one.bench.press_switch()
        one.until(lambda: one.assembly.ports.current.state.phase is Phase.ONLINE, 15_000)


# How long a value counts as current: by the stream's own rate, and one restart is one


RAW = encode_long(STATUS.code, bytes((1, 10, 0, 0)))


def streamed(device: Device, at: float) -> None:
    frame = Frame(Direction.MODULE_TO_HOST, RAW)
    device.apply(Received(frame, decode(RAW), Role.STREAMED, at))


@pytest.mark.parametrize(("period_s", "stale_after_s"), [(0.02, 1.0), (0.5, 1.0), (0.9, 1.35), (1.0, 1.5)])
def test_a_stream_that_stops_is_stale_by_its_own_rate(period_s: float, stale_after_s: float) -> None:
    device = Device()
    for turn in range(4):
        streamed(device, turn * period_s)
    last = 3 * period_s
    view = device.view(last)
    assert view.values["tilt_deg"].how is How.STREAMED
    for late_s, is_fresh in ((stale_after_s - 0.01, True), (stale_after_s + 0.01, False)):
        assert (view.fresh("tilt_deg", last + late_s) is not None) is is_fresh


def fed(*reports: tuple[float, int, float]) -> MotionWatch:
    watch = MotionWatch()
    for at, tilt_deg, acceleration_g in reports:
        watch.feed(Status(tilt_deg, acceleration_g, False, False), at)
    return watch


def test_the_extremes_of_all_reports_within_and_between_slots() -> None:
    watch = fed((1.0, 5, 1.0), (1.0625, 9, 0.8), (1.0938, 7, 1.3), (1.5, 3, 1.0), (2.0, 4, 1.1))
    assert watch.view(2.0) == MotionExtremes(1.0, 2.0, 3, 9, 0.8, 1.3)
    seen = watch.view(2.0)
    assert seen is not None
    assert seen.tilt_change_deg == 6
    watch.clear()
    assert watch.view(2.0) is None


def test_a_report_counts_for_two_and_a_half_seconds() -> None:
    assert WATCHED_FOR_S == 2.5
    watch = fed((1.0, 9, 1.3), (1.25, 5, 1.0))
    assert watch.view(3.5) == MotionExtremes(1.0, 1.25, 5, 9, 1.0, 1.3)
    assert watch.view(3.625) == MotionExtremes(1.25, 1.25, 5, 5, 1.0, 1.0)
    assert watch.view(3.75) is not None
    assert watch.view(3.875) is None


def test_a_slot_lasts_a_tenth_of_a_second() -> None:
    for later_s, since in ((0.09375, 1.0), (0.125, 1.125)):
        watch = fed((1.0, 9, 1.0), (1.0 + later_s, 5, 1.0))
        seen = watch.view(1.0 + later_s + WATCHED_FOR_S)
        assert seen is not None
        assert seen.since == since, "the slot is dropped when its last report is too old"
