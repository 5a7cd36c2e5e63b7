"""What the tests of ports share."""

from collections.abc import Iterator

import pytest

from app.engine.worker import Worker
from tests.support.patience import PATIENCE_S
from tests.support.processes import Running, run_module
from tests.unit.engine.terminals import Batches, Terminal


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    made = Terminal()
    yield made
    made.hang_up()


@pytest.fixture
def batches() -> Batches:
    return Batches()


@pytest.fixture
def worker(batches: Batches) -> Iterator[Worker]:
    made = Worker(batches)
    made.start()
    yield made
    assert made.stop(PATIENCE_S)


@pytest.fixture
def module() -> Iterator[Running]:
    with run_module("--uptime", "60", "--rate", "100") as running:
        yield running
