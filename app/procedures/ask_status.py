"""Queries the status so that no old report can pass for the reply.

    another question, answered  ->  the status

While the module streams, a status that was asked for cannot be told from a streamed one, and a line may hold streamed
ones back for seconds. The module answers in the order in which it was asked: what comes after the answer to another
question was said after that question went out. `DeviceView.proven` says whether that is short enough ago.
"""

from app.engine.procedure import Ask, EngineView, Inspect, Procedure
from protocol.catalogue import HEARTBEAT, STATUS
from protocol.events import Answered

TRIES = 3
"""The module may not know one of the questions; and of a slow one, the first answer may count as too old."""
HEARTBEAT_WAITS_S = (1.0,)


def ask_status() -> Procedure[bool]:
    """Whether the module has just said how it stands. What it said is in `EngineView.device`, as every status."""
    for _ in range(TRIES):
        outcome = yield Ask(STATUS.query(), is_fenced=True)
        sight: EngineView = yield Inspect()
        if sight.device.proven("active", sight.now) is not None:
            return True
        if not isinstance(outcome, Answered):
            alive = yield Ask(HEARTBEAT.query(), HEARTBEAT_WAITS_S)
            if not isinstance(alive, Answered):
                break
    return False
