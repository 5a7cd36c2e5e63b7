"""Queries the status so that an old report cannot be taken for the reply.

    another question, answered  ->  the status

While the module streams, the reply looks like a streamed status, which a line may delay by seconds. As the module
answers in order, a status after the answer to another question was sent after that question. `DeviceView.proven` tells
whether that is recent enough.
"""

from app.engine.procedure import Ask, EngineView, Inspect, Procedure, is_alive
from protocol.catalogue import STATUS
from protocol.events import Answered

TRIES = 3
"""The module may not know one of the questions, and the first answer of a slow module may be too old."""


def ask_status() -> Procedure[bool]:
    """Query the status; return whether it is proven to be recent. The values are in `EngineView.device`."""
    for _ in range(TRIES):
        outcome = yield Ask(STATUS.query(), is_fenced=True)
        view: EngineView = yield Inspect()
        if view.device.proven("active", view.now) is not None:
            return True
        if not isinstance(outcome, Answered) and not (yield from is_alive()):
            break
    return False
