"""Bounded, non-blocking queue of orders for the recorder."""

import threading
from dataclasses import dataclass, field, replace

from app.engine.worker import Batch


@dataclass(frozen=True, slots=True)
class Heading:
    """What is known about a session when it begins."""

    port: str
    baud_rate: int
    module: str = ""
    program: str = ""


@dataclass(frozen=True, slots=True)
class Begin:
    """`number`: the how manieth beginning it is tells a failure of this session from one of the session before."""

    heading: Heading
    at: float
    number: int


@dataclass(frozen=True, slots=True)
class Name:
    module: str


@dataclass(frozen=True, slots=True)
class Lost:
    """So many status reports and events did not fit."""

    count: int


@dataclass(frozen=True, slots=True)
class End:
    is_stop: bool = False


@dataclass(frozen=True, slots=True)
class Settle:
    done: threading.Event = field(default_factory=threading.Event)


Order = Batch | Begin | Name | Lost | End | Settle


class RecorderQueue:
    """From any thread to the recorder's. Batches beyond `most_waiting` reports and events are left out, and counted;
    everything else always fits."""

    def __init__(self, most_waiting: int) -> None:
        self._most_waiting = most_waiting
        self._came = threading.Condition()
        self._orders: list[Order] = []
        self._waiting = 0
        self._latest: Batch | None = None
        self._lost = 0
        self._is_urgent = False

    def put(self, order: Order) -> None:
        """To be obeyed at once."""
        with self._came:
            self._make_up()
            self._orders.append(order)
            self._is_urgent = True
            self._came.notify_all()

    def offer(self, batch: Batch) -> int:
        """To be obeyed in due time; how many of its reports and events did not fit."""
        count = len(batch.samples) + len(batch.events)
        with self._came:
            if self._waiting + count + 1 > self._most_waiting:
                self._latest = replace(batch, samples=(), events=(), finished=())
                self._lost += count
                return count
            self._make_up()
            self._orders.append(batch)
            self._waiting += count + 1
            return 0

    def pop_all(self, wait_s: float | None) -> list[Order]:
        """All that waits, once something is urgent or the time is over; None waits for something urgent."""
        with self._came:
            self._came.wait_for(lambda: self._is_urgent, wait_s)
            orders, self._orders = self._orders, []
            self._waiting, self._is_urgent = 0, False
        return orders

    def _make_up(self) -> None:
        """What was left out is said where it is missing, and how things stood afterwards."""
        if self._latest is not None:
            self._orders += (Lost(self._lost), self._latest)
            self._latest, self._lost = None, 0
