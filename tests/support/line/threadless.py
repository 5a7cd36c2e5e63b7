"""The worker without its thread: the one that the window and the commands use, run when a test says so."""

from typing import Any

from app.engine import worker
from app.engine.procedure import PortLost
from app.engine.transport import PortError
from tests.support.line.sim_line import FakeClock


class ThreadlessWorker(worker.Worker):
    """`turn` is one round of its loop."""

    def __init__(self, callback: Any, clock: FakeClock) -> None:
        super().__init__(callback, clock=clock, with_sleep=None)
        self._has_ended = False

    def start(self) -> None:
        """Has no effect: there is no thread to start."""

    def turn(self) -> bool:
        """Run one round; return whether there was anything to do."""
        if self._has_ended or (self._session is None and self._orders.empty()):
            return False
        try:
            self._turn()
        except PortError as error:
            self._lose_port(error)
        except Exception as error:  # noqa: BLE001  as the worker's own loop, which tells of it and goes on
            self._lose_port(error)
            worker.report_uncaught_error(error)  # type: ignore[attr-defined]  # where tests replace it
        self._publish()
        return True

    def stop(self, deadline_s: float = 2.0) -> bool:
        """Closing the port has a limit of its own."""
        if not self._has_ended:
            self._order(self._end)
            while not self._is_stopping:
                self.turn()
            self._has_ended = True
            self._end_session(PortLost())
            self._pending.is_urgent = True
            self._publish()
        return True
