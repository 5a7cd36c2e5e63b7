"""A folder of a thousand flight logs of a minute: found, read, summarised and judged, each kind."""

import os
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import numpy as np

from app.flights.read_log import find_logs, summarise_log
from tests.bench.kit import Figure, at_most
from tests.support.flights import log_bytes as made
from tests.support.flights.made_flights import crash, ordinary_flight

AIM_S: Final = 30.0
LOGS: Final = 1000
DIFFERENT: Final = 10
"""Logs that are made; the others are links to them."""


def _table(time_s: np.ndarray, tilt_deg: np.ndarray, force_g: np.ndarray) -> bytes:
    """As a logger writes one: bare names, in milliseconds and m/s², with columns that nobody asks for."""
    rows = ["timestamp,roll,pitch,yaw,acc_x,acc_y,acc_z,temperature"]
    for at_s, tilt, force in zip(time_s, tilt_deg, force_g, strict=True):
        x, z = 0.6 * 9.80665 * force, -0.8 * 9.80665 * force
        rows.append(f"{at_s * 1000:.0f},{tilt:.2f},0.31,112.5,{x:.4f},0.0123,{z:.4f},31.5")
    return "\n".join([*rows, ""]).encode()


def _with_commas(*flight: np.ndarray) -> bytes:
    return _table(*flight).replace(b",", b";").replace(b".", b",")


KINDS: Final[dict[str, Callable[..., bytes]]] = {
    "CSV": _table,
    "CSV with decimal commas": _with_commas,
    "DataFlash as text": made.dataflash_text,
    "DataFlash": made.dataflash_bytes,
    "ULog": made.ulog_bytes,
}


def logs() -> Iterator[Figure]:
    for kind, write in KINDS.items():
        with tempfile.TemporaryDirectory() as folder:
            for number in range(LOGS):
                path = Path(folder) / f"{number:04}"
                if number < DIFFERENT:
                    make = crash if number % 3 == 0 else ordinary_flight
                    flight = make(str(number), np.random.default_rng(number), seconds=60.0)
                    path.write_bytes(write(flight.time_s, flight.tilt_deg, flight.specific_force_g))
                else:
                    os.link(Path(folder) / f"{number % DIFFERENT:04}", path)
            began = time.perf_counter()
            found = [summarise_log(path) for path in find_logs([Path(folder)])]
            took_s = time.perf_counter() - began
        assert len(found) == LOGS
        assert all(log.flight is not None for log in found), kind
        yield at_most(f"{LOGS} logs, {kind}", took_s, AIM_S, "{:.1f} s")
