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
# Shorter names occur in ordinary words and are not replaced.
SHORTEST_NAME = 3
_HOME = re.compile(
    r"((?:/home/|/Users/|[A-Za-z]:[\\/]+(?:Users|Documents and Settings)[\\/]+))"
    r"([^/\\\n\"'<>|:]{1,64}?(?=[/\\])|[^/\\\s\"'<>|:]+)"
)


def scrub(text: str, user: str, computer: str) -> str:
    """`text` with both names, and every user name in a path, replaced."""
    text = _HOME.sub(lambda match: match[1] + USER, text)
    for name, instead in ((computer, COMPUTER), (computer.partition(".")[0], COMPUTER), (user, USER)):
        if len(name) >= SHORTEST_NAME:
            text = re.sub(rf"(?<![A-Za-z0-9]){re.escape(name)}(?![A-Za-z0-9])", instead, text, flags=re.IGNORECASE)
    return text


def bundle_files(
    *,
    version: str,
    log: str = "",
    connection: Connection,
    conversation: ConversationView,
    statistics: LinkStatistics,
    preferences: Mapping[str, object] = MappingProxyType({}),
    traffic: Sequence[Event] = (),
) -> dict[str, str]:
    """The text of each file, by name. `preferences`: language, theme … `traffic`: the latest, oldest first."""
    about = {
        "program": f"DPS-S Configurator {version}",
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "preferences": dict(preferences),
        "link": _link(connection, statistics),
        "conversation": conversation.number,
        "ended": None if conversation.ended is None else conversation.ended.reason.name,
        "last_values": {key: known.value for key, known in sorted(conversation.values.items())},
    }
    texts = {"about.json": json.dumps(about, indent=2, ensure_ascii=False, default=str) + "\n", "log.txt": log}
    if traffic:
        # As `dps-s decode` reads it.
        began_at = traffic[0].at
        started_at = datetime.fromtimestamp(began_at + wall_offset_s(), UTC)
        lines = [f"# started: {started_at.isoformat(timespec='seconds')}"]
        lines += [entry.line for entry in entries_of(traffic, began_at)]
        texts["capture.txt"] = "\n".join([*lines, ""])
    user = ""
    with suppress(OSError, KeyError, ImportError):
        user = getpass.getuser()
    return {name: scrub(text, user, socket.gethostname()) for name, text in texts.items() if text}


def write_bundle(path: Path, files: Mapping[str, str]) -> None:
    """Writes the zip atomically. Raises OSError."""
    with whole_file(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text.encode())


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
    for share in (0.5, 0.95, 1.0):
        link[f"round_trip_s {share:.0%}"] = statistics.quantile_s(share)
    return link
