"""The bridge: what waits is joined, but never across two conversations or two ports."""

import threading

from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.conversation import ConversationView
from app.engine.worker import Batch, Connection
from protocol.events import Ended, EndReason
from tests.support.records.recordings_made import CLOSED, OPEN, batch, report
from ui.core.bridge import Bridge


def test_after_a_stall_there_is_one_batch_a_conversation(qapp: QApplication) -> None:
    bridge, connection, came = Bridge(), Connection(), list[Batch]()
    bridge.batch.connect(came.append)
    ended = Ended(EndReason.SILENT, 2.0)
    first, second = ConversationView(number=1), ConversationView(number=2)
    bridge.deliver(Batch(1.0, connection, first, None))
    bridge.deliver(Batch(2.0, connection, first._replace(ended=ended), None, events=(ended,)))
    bridge.deliver(Batch(3.0, connection, second, None))
    qapp.processEvents()
    assert [(batch.conversation.number, batch.events) for batch in came] == [(1, (ended,)), (2, ())]
    assert came[0].conversation.ended is ended


def test_samples_of_two_ports_are_not_joined(qtbot: QtBot, qapp: QApplication) -> None:
    bridge, other, came = Bridge(), OPEN._replace(port="/dev/ttyACM0", opening=7), list[Batch]()
    bridge.batch.connect(came.append)
    for at_s, connection in ((1.0, OPEN), (2.0, OPEN), (3.0, CLOSED), (4.0, other)):
        bridge.deliver(batch(at_s, report(at_s, 3), connection=connection))
    qtbot.waitUntil(lambda: len(came) == 3)
    assert [(one.connection, len(one.samples)) for one in came] == [(OPEN, 2), (CLOSED, 1), (other, 1)]


def test_no_batch_is_lost_while_the_window_stalls(qtbot: QtBot, qapp: QApplication) -> None:
    bridge, came, count = Bridge(), list[Batch](), 5000
    bridge.batch.connect(came.append)

    def deliver() -> None:
        for number in range(count):
            bridge.deliver(Batch(float(number), Connection(), ConversationView(), None, events=(number,)))  # type: ignore[arg-type]

    thread = threading.Thread(target=deliver)
    thread.start()
    thread.join()  # the window's thread stands still all the while
    assert came == []
    qtbot.waitUntil(lambda: bool(came) and came[-1].at == count - 1)
    assert [event for one in came for event in one.events] == list(range(count))
    bridge.close()
    bridge.deliver(came[0])
    qapp.processEvents()
    assert len(came) == 1
