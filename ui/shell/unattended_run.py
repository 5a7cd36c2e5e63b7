"""Saves a screenshot and the values of an unattended run."""

import json
from pathlib import Path

from PySide6.QtWidgets import QWidget

from app.engine.device import STATUS_KEYS
from ui.core.connector import Connector

PICTURE = "live.png"
VALUES = "values.json"


def has_seen_status(connector: Connector) -> bool:
    """Whether the module's status is known and not stale."""
    device, now = connector.current.device, connector.clock()
    return all(device.fresh(key, now) is not None for key in STATUS_KEYS)


def values_seen(connector: Connector) -> dict[str, object]:
    """All known values of device and link, for `VALUES`."""
    port, now = connector.current, connector.clock()
    device, link = port.device, port.last.link
    values = {
        key: {
            "value": known.value,
            "how": known.how.value,
            "age_s": round(now - known.at, 3),
            "doubt": None if known.stale_reason is None else known.stale_reason.value,
        }
        for key in sorted(device.values)
        if (known := device.known(key, now)) is not None
    }
    seen: dict[str, object] = {
        "port": port.connection.port,
        "baud_rate": port.connection.baud_rate,
        "presence": device.presence.value,
        "is_streaming": device.is_streaming,
        "stream_hz": round(device.stream_hz, 1),
        "values": values,
    }
    if link is not None:
        median_s = link.round_trip_median_s
        seen["link"] = {
            "frames": link.counters.frames,
            "sent": link.counters.sent,
            "rejected_bytes": link.counters.rejected,
            "time_outs": link.counters.time_outs,
            "round_trip_median_ms": None if median_s is None else round(median_s * 1000, 2),
        }
    return seen


def write_evidence(folder: Path, window: QWidget, connector: Connector) -> None:
    """Writes both files into `folder`, which is created if needed. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(values_seen(connector), indent=2, ensure_ascii=False)
    (folder / VALUES).write_text(text + "\n", encoding="utf-8")
    picture = folder / PICTURE
    if not window.grab().save(str(picture)):
        raise OSError(f"{picture} could not be written")
