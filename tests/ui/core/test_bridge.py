"""The bridge: what waits is joined, but never across two conversations."""

from PySide6.QtWidgets import QApplication

from app.engine.conversation import ConversationView
from app.engine.worker import Batch, Connection
from protocol.events import Ended, EndReason
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
