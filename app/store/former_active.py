"""What a file of a development build leaves ACTIVE: nothing else of it is taken over.

Its audit log had an intent (`act`) and what came of it (`outcome`, linked by the intent's hash), both as JSON.
"""

import json
import logging
import sqlite3
from contextlib import closing
from pathlib import Path

from app.safety.left_active import LEFT
from app.store.opening import connect_to_read

_QUERY = """
    SELECT a.number, a.made_at, a.payload, o.payload FROM facts a
    LEFT JOIN facts o ON o.kind = 'outcome' AND o.link = a.hash
    WHERE a.kind = 'act' AND a.link IN ('activate', 'lock', 'shutdown') ORDER BY a.number
"""
_LEAVES_ACTIVE = (("activate", "confirmed"), ("activate", "unknown"), ("lock", "refused"), ("lock", "unknown"))
_log = logging.getLogger(__name__)


def former_state(path: Path) -> dict[str, object]:
    """By key of the state; empty where the file cannot be read, which is logged."""
    try:
        with closing(connect_to_read(path)) as connection:
            rows = connection.execute(_QUERY).fetchall()
        return _left(rows)
    except (sqlite3.Error, ValueError, LookupError, TypeError, AttributeError) as error:  # nothing in it is trusted
        _log.warning("What %s leaves ACTIVE cannot be read: %s", path, error)
        return {}


def _left(rows: list[tuple[int, str, str, str | None]]) -> dict[str, object]:
    left: dict[str, tuple[str, dict[str, object]]] = {}
    for number, at, payload, ended in rows:
        content = json.loads(payload)
        outcome = "unknown" if ended is None else json.loads(ended)["outcome"]
        act, port, detail = content["act"], str(content["port"]), content["detail"]
        module, adapter = str(detail.get("module", "")), str(detail.get("adapter", ""))
        # A module without a name is known by its connection.
        known_as = module or f"{detail.get('run')} {adapter} {port}"
        if port.startswith("sim://"):
            continue
        if (act, outcome) in _LEAVES_ACTIVE:
            state: dict[str, object] = {"module": module, "port": port, "adapter": adapter, "at": at}
            state["is_lock_unconfirmed"] = act == "lock"
            left[known_as] = f"{LEFT}former {number}", state
        elif act != "activate" and outcome == "confirmed" and not detail.get("is_in_doubt"):
            left.pop(known_as, None)
    return dict(left.values())
