"""Writes a recording as MCAP (https://mcap.dev), JSON with a schema per topic, for PlotJuggler and Foxglove.

/status     tilt_deg, acceleration_g, triggered, active
/cell       cell_voltage_v
/light      light_v
/limits     limits reported by the module; null where unknown
/events     event, port
/line/rx    bytes of the module (base64), /line/tx bytes of the host
"""

import base64
import heapq
import json
from collections.abc import Callable, Iterator, Mapping
from typing import IO, Final, NamedTuple

import numpy as np
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, Writer

from app.captures.entries import Way
from app.recordings.excerpt import Excerpt
from app.recordings.file_layout import VERSION
from app.recordings.recording import Recording
from app.recordings.table import ROWS_AT_ONCE
from app.samples.ring_buffers import Seconds

_NUMBER: Final = {"type": "number"}
_KNOWN_NUMBER: Final = {"type": ["number", "null"]}
_FLAG: Final = {"type": "boolean"}
_TEXT: Final = {"type": "string"}
_BYTES: Final = {"type": "string", "contentEncoding": "base64"}
TOPICS: Final[Mapping[str, Mapping[str, object]]] = {
    "/status": {"tilt_deg": _NUMBER, "acceleration_g": _NUMBER, "triggered": _FLAG, "active": _FLAG},
    "/cell": {"cell_voltage_v": _NUMBER},
    "/light": {"light_v": _NUMBER},
    "/limits": {
        "attitude_threshold_deg": _KNOWN_NUMBER,
        "reset_angle_deg": _KNOWN_NUMBER,
        "freefall_acceleration_g": _KNOWN_NUMBER,
        "light_threshold_v": _KNOWN_NUMBER,
    },
    "/events": {"event": _TEXT, "port": _TEXT},
    "/line/rx": {"data": _BYTES},
    "/line/tx": {"data": _BYTES},
}
"""Names include the unit, as in all files of the program."""
_TOPIC_OF_WAY: Final = {Way.IN: "/line/rx", Way.OUT: "/line/tx"}


class _Message(NamedTuple):
    time_s: float
    topic: str
    data: bytes


def write_mcap(recording: Recording, file: IO[bytes], *, report: Callable[[float], None]) -> int:
    """Writes the messages in order of time; returns their number. `report` gets the share done, and may raise."""
    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start(profile="", library="DPS-S Configurator")
    channels = {topic: _register(writer, topic, fields) for topic, fields in TOPICS.items()}
    writer.add_metadata("dps-s recording", _about(recording))
    excerpt = recording.excerpt(recording.start_s, recording.end_s)
    wall_offset_s = recording.wall_offset_s
    rows = len(excerpt.time_s)
    row = count = 0

    def write_status(stop: int) -> None:
        nonlocal row, count
        for first in range(row, stop, ROWS_AT_ONCE):
            part = slice(first, min(stop, first + ROWS_AT_ONCE))
            for at_ns, data in zip(_wall_ns(excerpt.time_s[part], wall_offset_s), _status(excerpt, part), strict=True):
                writer.add_message(channels["/status"], at_ns, data, at_ns)
            report(part.stop / rows)
        count += max(0, stop - row)
        row = max(row, stop)

    for number, message in enumerate(_others(recording, excerpt)):
        if number % 500 == 0:
            report(row / rows if rows else 0.0)
        write_status(int(np.searchsorted(excerpt.time_s, message.time_s, "right")))
        at_ns = _wall_ns(np.array([message.time_s]), wall_offset_s)[0]
        writer.add_message(channels[message.topic], at_ns, message.data, at_ns)
        count += 1
    write_status(rows)
    writer.finish()  # type: ignore[no-untyped-call]
    report(1.0)
    return count


def _register(writer: Writer, topic: str, fields: Mapping[str, object]) -> int:
    schema = {
        "type": "object",
        "title": f"dps-s{topic.replace('/', '.')}",
        "properties": dict(fields),
        "required": list(fields),
    }
    identity = writer.register_schema(f"dps-s{topic.replace('/', '.')}", SchemaEncoding.JSONSchema, _json(schema))
    return writer.register_channel(topic, MessageEncoding.JSON, identity)


def _wall_ns(times: Seconds, wall_offset_s: float) -> list[int]:
    """Nanoseconds since 1970, added as integers to avoid rounding."""
    found: list[int] = (np.rint(times * 1e9).astype(np.int64) + round(wall_offset_s * 1e9)).tolist()
    return found


def _about(recording: Recording) -> dict[str, str]:
    entry, opening = recording.entry, recording.opening
    return {
        "format": str(VERSION),
        "program": opening.program,
        "started_at": entry.started_at.isoformat(),
        "port": entry.port,
        "baud_rate": str(entry.baud_rate),
        "module": entry.module,
        "part": str(entry.part),
        "simulated": str(entry.is_simulated).lower(),
        "was_cut_off": str(entry.was_cut_off).lower(),
        "missing": str(recording.missing_count),
    }


def _status(excerpt: Excerpt, part: slice) -> Iterator[bytes]:
    words = ("false", "true")
    columns = zip(
        excerpt.tilt_deg[part].tolist(),
        excerpt.acceleration_g[part].tolist(),
        excerpt.is_triggered[part].tolist(),
        excerpt.is_active[part].tolist(),
        strict=True,
    )
    for tilt, acceleration, is_triggered, is_active in columns:
        yield (
            f'{{"tilt_deg":{tilt:.6g},"acceleration_g":{acceleration:.6g},'
            f'"triggered":{words[is_triggered]},"active":{words[is_active]}}}'
        ).encode()


def _others(recording: Recording, excerpt: Excerpt) -> Iterator[_Message]:
    """Everything but the status reports, in order of time."""
    return heapq.merge(
        _slow("/cell", "cell_voltage_v", excerpt.cell_time_s.tolist(), excerpt.cell_voltage_v.tolist()),
        _slow("/light", "light_v", excerpt.light_time_s.tolist(), excerpt.light_v.tolist()),
        _limits(recording),
        (_Message(one.time_s, "/events", _json({"event": one.kind.value, "port": one.port}))
         for one in recording.markers),
        _traffic(recording),
    )  # fmt: skip


def _slow(topic: str, name: str, times: list[float], values: list[float]) -> Iterator[_Message]:
    for time_s, value in zip(times, values, strict=True):
        yield _Message(time_s, topic, f'{{"{name}":{value:.6g}}}'.encode())


def _limits(recording: Recording) -> Iterator[_Message]:
    for time_s, limits in recording.limits:
        fields = {
            "attitude_threshold_deg": limits.fires_deg,
            "reset_angle_deg": limits.rearms_deg,
            "freefall_acceleration_g": limits.free_fall_g,
            "light_threshold_v": limits.light_v,
        }
        yield _Message(time_s, "/limits", _json(fields))


def _traffic(recording: Recording) -> Iterator[_Message]:
    start_s = recording.opening.start_s
    for at_s, way, raw in recording.traffic():
        text = base64.b64encode(raw).decode()
        yield _Message(start_s + at_s, _TOPIC_OF_WAY[way], f'{{"data":"{text}"}}'.encode())


def _json(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=False).encode("utf-8", "backslashreplace")
