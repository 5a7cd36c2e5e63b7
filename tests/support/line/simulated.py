"""Bytes of a simulated module without a line between."""

from typing import Any

from app.simulator.module import Memory, Physics, SimulatedModule
from app.simulator.setup import Setup


def running(world: Physics | None = None, memory: Memory | None = None, **options: Any) -> SimulatedModule:
    """A module that was switched on a minute before time 0."""
    module = SimulatedModule(world or Physics(), Setup(**options), memory=memory)
    module.power_on(-60.0)
    module.collect(0.0)
    return module


def receive(module: SimulatedModule, data: bytes, now_s: float) -> bytes:
    """What it sends by now, ignoring the baud rate."""
    module.receive(data, now_s)
    return tick(module, now_s)


def tick(module: SimulatedModule, now_s: float) -> bytes:
    """Bytes that are due by now."""
    return b"".join(sent.data for sent in module.collect(now_s))


def say(module: SimulatedModule, frame: str, now_s: float = 0.0) -> str:
    """The replies to `frame`, in hexadecimal."""
    return receive(module, bytes.fromhex(frame), now_s).hex(" ")
