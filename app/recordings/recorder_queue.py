"""Bounded, non-blocking queue of orders to the recorder."""

import threading
from dataclasses import replace
from typing import NamedTuple

from app.engine.worker import Batch


class Heading(NamedTuple):
    """What is known when a session begins."""

    port: str
    baud_rate: int
    module: str = ""


class Begin(NamedTuple):
    """`number` counts the sessions, to tell a failure of this one from one of an earlier session."""

    heading: Heading
    at: float
    number: int


class Name(NamedTuple):
    module: str


class Lost(NamedTuple):
    """Number of status reports and events that did not fit."""

    events: int


class End(NamedTuple):
    is_stop: bool = False


class Settle(NamedTuple):
    done: threading.Event


Order = Batch | Begin | Name | Lost | End | Settle


class RecorderQueue:
    """Thread-safe. Batches beyond `max_waiting` reports and events are dropped and counted; other orders always
    fit."""

    def __init__(self, max_waiting: int) -> None:
        self._max_waiting = max_waiting
        self._came = threading.Condition()
        self._orders: list[Order] = []
        self._waiting = 0
        self._latest: Batch | None = None
        self._lost = 0
        self._is_urgent = False

    def put(self, order: Order) -> None:
        """Adds an order that is processed at once."""
        with self._came:
            self._make_up()
            self._orders.append(order)
            self._is_urgent = True
            self._came.notify_all()

    def offer(self, batch: Batch) -> int:
        """Adds a batch that is processed later; returns how many of its reports and events did not fit."""
        count = len(batch.samples) + len(batch.events)
        with self._came:
            if self._waiting + count + 1 > self._max_waiting:
                self._latest = replace(batch, samples=(), events=(), finished=())
                self._lost += count
                return count
            self._make_up()
            self._orders.append(batch)
            self._waiting += count + 1
            return 0

    def pop_all(self, wait_s: float | None) -> list[Order]:
        """All orders, as soon as one is urgent or after `wait_s`; None waits without limit."""
        with self._came:
            self._came.wait_for(lambda: self._is_urgent, wait_s)
            orders, self._orders = self._orders, []
            self._waiting, self._is_urgent = 0, False
        return orders

    def _make_up(self) -> None:
        """Inserts a note of what was dropped, and the state after it."""
        if self._latest is not None:
            self._orders += (Lost(self._lost), self._latest)
            self._latest, self._lost = None, 0
