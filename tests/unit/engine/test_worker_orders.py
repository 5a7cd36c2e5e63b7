"""An order does not wait for the port: it ends the read that waits for bytes."""

import sys
from collections.abc import Callable

import pytest

from app.engine.procedure import Job
from app.engine.worker import Batch, Worker
from app.procedures.find import await_module
from app.procedures.lock import lock
from app.procedures.read import read_everything
from app.simulator import bench
from tests.support.patience import PATIENCE_S

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals on Windows")


def ignore(_: Batch) -> None:
    pass


@pytest.mark.parametrize("options", ["", "&delay-ms=60"])
@pytest.mark.parametrize("leave", [Worker.close, Worker.stop])
@pytest.mark.promise("l")
def test_a_lock_goes_out_although_the_port_is_closed_at_once(options: str, leave: Callable[[Worker], object]) -> None:
    """Whoever presses LOCK and leaves gets it: the closing waits for it, within its limit."""
    worker = Worker(ignore)
    worker.start()
    try:
        worker.open(f"sim://lock-and-leave?active=yes&uptime=60{options}", 115200)
        assert worker.submit(Job(await_module())).wait(PATIENCE_S)
        reading = worker.submit(Job(read_everything()))
        locking = worker.submit(Job(lock(), outlives=True), is_urgent=True)
        leave(worker)
        assert locking.wait(PATIENCE_S)
        assert reading.wait(PATIENCE_S)
        assert not bench.module("lock-and-leave").module.state.is_active
        assert locking.outcome().is_acknowledged or locking.outcome().is_locked  # repeated, the report may come first
    finally:
        assert worker.stop(PATIENCE_S)
        bench.remove_bench("lock-and-leave")
