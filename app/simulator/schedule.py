"""Scheduled events of the simulated module, in order of time."""

import heapq
import itertools
import math
from collections.abc import Callable


class Schedule:
    def __init__(self) -> None:
        self._plans: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()

    @property
    def next_s(self) -> float:
        """When the first event is due; infinity for none."""
        return self._plans[0][0] if self._plans else math.inf

    def add(self, at_s: float, act: Callable[[], None]) -> None:
        heapq.heappush(self._plans, (at_s, next(self._order), act))

    def do_next(self) -> None:
        heapq.heappop(self._plans)[2]()

    def clear(self) -> None:
        self._plans.clear()
