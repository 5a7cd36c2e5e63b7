"""The support bundle: a zip that contains exactly what its preview shows.

User names in paths, the user's and the computer's name are replaced. Names of modules, files and ports, serial numbers
(of an adapter, in the name of its port) and network addresses stay, and the window says so beside the preview. The
environment and other files are never read.
"""

import getpass
import json
import platform
import re
import socket
import zipfile
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from app.captures.traffic import entries_of
from app.diagnosis.causes import explain
from app.diagnosis.link_state import LinkStatistics
from app.engine.conversation import ConversationView
from app.engine.worker import Connection
from app.system.clock import wall_offset_s
from app.system.files import whole_file
from protocol.events import Event

USER = "<user>"
COMPUTER = "<computer>"
# Shorter names occur in ordinary words and are not replaced; others identify nobody, and occur in paths and messages.
SHORTEST_NAME = 3
_USUAL = frozenset({"root", "user", "admin", "public", "shared", "localhost"})
_HOME = re.compile(
    r"((?:/home/|/Users/|[A-Za-z]:[\\/]+(?:Users|Documents and Settings)[\\/]+))"
    r"([^/\\\n\"'<>|:]{1,64}?(?=[/\\])|[^/\\\s\"'<>|:]+)"
)


class Names(NamedTuple):
    """Names that must not be in the bundle."""

    user: str = ""
    computer: str = ""
    home: str = ""


def scrub(text: str, names: Names) -> str:
    """`text` with the names, and every user name in a path, replaced."""
    if len(names.home) > SHORTEST_NAME:
        text = text.replace(names.home, f"~{USER}")
    text = _HOME.sub(lambda match: match[1] + USER, text)
    for name, instead in ((names.computer, COMPUTER), (names.computer.partition(".")[0], COMPUTER), (names.user, USER)):
        if len(name) >= SHORTEST_NAME and name.lower() not in _USUAL:
            text = re.sub(rf"(?<![A-Za-z0-9]){re.escape(name)}(?![A-Za-z0-9])", instead, text, flags=re.IGNORECASE)
    return text


def bundle_files(
    names: Names | None = None,
    *,
    version: str,
    log: str = "",
    connection: Connection,
    conversation: ConversationView,
    now: float = 0.0,
    statistics: LinkStatistics,
    preferences: Mapping[str, object] = MappingProxyType({}),
    traffic: Sequence[Event] = (),
) -> dict[str, str]:
    """The text of each file, by name. `names`: None for those of this computer. `now`: of the program's clock.
    `preferences`: language, theme … `traffic`: the latest, oldest first."""
    if names is None:
        user = ""
        with suppress(OSError, KeyError, ImportError):
            user = getpass.getuser()
        names = Names(user, socket.gethostname(), str(Path.home()))
    about = {
        "program": f"DPS-S Configurator {version}",
        "python": platform.python_version(),
        "system": platform.system(),
        "release": platform.release(),
        "machine": platform.machine(),
    }
    texts = {
        "about.json": _json(about),
        "link.json": _json(_link(connection, statistics)),
        "module.json": _json(_module(conversation, now)),
        "preferences.json": _json(dict(preferences)),
        "log.txt": log,
    }
    if traffic:
        # As `dps-s decode` reads it.
        began_at = traffic[0].at
        started_at = datetime.fromtimestamp(began_at + wall_offset_s(), UTC)
        lines = [f"# started: {started_at.isoformat(timespec='seconds')}"]
        lines += [entry.line for entry in entries_of(traffic, began_at)]
        texts["capture.txt"] = "\n".join([*lines, ""])
    return {name: scrub(text, names) for name, text in texts.items() if text}


def write_bundle(path: Path, files: Mapping[str, str]) -> None:
    """Writes the zip atomically. Raises OSError."""
    with whole_file(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            # A fixed time and mode, so that the zip contains no more than the preview.
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, text.encode())


def _json(value: object) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False, default=str) + "\n"


def _link(connection: Connection, statistics: LinkStatistics) -> dict[str, object]:
    link: dict[str, object] = {
        "port": connection.port,
        "baud_rate": connection.baud_rate,
        "state": connection.state.value,
    }
    if connection.trouble is not None:
        link["trouble"] = connection.trouble.kind.value
        link["what"] = explain(connection.trouble).what
        link["driver_says"] = connection.trouble.detail
    for name, count in vars(statistics.totals).items():
        link[name] = {key.value: n for key, n in count.most_common()} if isinstance(count, Counter) else count
    trips = {f"{share:.0%}": statistics.quantile_s(share) for share in (0.5, 0.95, 1.0)}
    link["losses"] = statistics.losses
    link["round_trips_ms"] = {share: round(trip * 1000, 1) for share, trip in trips.items() if trip is not None}
    return link


def _module(conversation: ConversationView, now: float) -> dict[str, object]:
    known = {key: conversation.known(key, now) for key in sorted(conversation.values)}
    ended = conversation.ended
    return {
        "conversation": conversation.number,
        "is_going": conversation.is_going,
        "ended": None if ended is None else ended.reason.name,
        "values": {
            key: {
                "value": one.value,
                "how": one.how.value,
                "age_s": round(now - one.at, 1),
                "is_stale": one.is_stale,
            }
            for key, one in known.items()
            if one is not None
        },
    }
