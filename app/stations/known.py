"""Known stations: public keys with names, one line each. Those whose line begins with "-" are revoked.

A revoked station was trusted once, and its key is lost or was copied: nothing that it signed counts any more.
"""

from pathlib import Path
from typing import Final, NamedTuple

from app.stations.station import KEY_BYTES, decoded, encoded, find_station, fingerprint_of
from app.system.files import write_whole
from app.text.messages import clean
from app.text.user_error import UserError

KNOWN_FILE: Final = "stations.txt"
MAX_NAME_LENGTH: Final = 60
_LARGEST_FILE: Final = 1_000_000
_REVOKED: Final = "-"


class KnownStation(NamedTuple):
    """`is_own`: the station of this computer."""

    public: bytes
    name: str
    is_own: bool = False
    is_revoked: bool = False

    @property
    def fingerprint(self) -> str:
        return fingerprint_of(self.public)


class Stations:
    """The stations of a data folder; reads the file each time. Thread-safe."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def known(self) -> tuple[KnownStation, ...]:
        """This computer's first if it has a key. Unreadable lines are skipped."""
        try:
            own = find_station(self._folder)
        except UserError:
            own = None
        first = () if own is None else (KnownStation(own.public, "", is_own=True),)
        return (*first, *(station for station in self._others() if own is None or station.public != own.public))

    def revoked(self) -> frozenset[str]:
        """Public keys, as in facts, of the stations of which nothing counts any more, whatever they signed."""
        return frozenset(encoded(station.public) for station in self._others() if station.is_revoked)

    def find(self, public: bytes) -> KnownStation | None:
        return next((station for station in self.known() if station.public == public), None)

    def trust(self, public: bytes, name: str) -> KnownStation:
        """Trust this key under this name; a known key is renamed. Raises OSError."""
        new = KnownStation(public, clean(name.strip(), longest=MAX_NAME_LENGTH) or fingerprint_of(public))
        self._write((*(station for station in self._others() if station.public != public), new))
        return new

    def remove(self, fingerprint: str, *, is_revoked: bool = False) -> KnownStation | None:
        """No longer trusted; a revoked one stays revoked, else its facts would count again. `is_revoked`: its key is
        lost or was copied. None if no station has this fingerprint. Raises OSError."""
        others = self._others()
        known = next((station for station in others if is_same_fingerprint(station.fingerprint, fingerprint)), None)
        if known is not None:
            known = known._replace(is_revoked=is_revoked or known.is_revoked)
            revoked = (known,) if known.is_revoked else ()
            self._write((*(station for station in others if station.public != known.public), *revoked))
        return known

    def _others(self) -> tuple[KnownStation, ...]:
        try:
            with (self._folder / KNOWN_FILE).open("rb") as file:
                text = file.read(_LARGEST_FILE).decode("utf-8", "replace")
        except OSError:
            return ()
        stations: dict[bytes, KnownStation] = {}
        for line in text.splitlines():
            key, _, name = line.strip().partition(" ")
            public = decoded(key.removeprefix(_REVOKED), KEY_BYTES)
            if public is not None:
                is_revoked = key.startswith(_REVOKED)
                stations[public] = KnownStation(
                    public, clean(name.strip(), longest=MAX_NAME_LENGTH), is_revoked=is_revoked
                )
        return tuple(stations.values())

    def _write(self, stations: tuple[KnownStation, ...]) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        lines = [
            f"{_REVOKED if station.is_revoked else ''}{encoded(station.public)} {station.name}\n"
            for station in stations
        ]
        write_whole(self._folder / KNOWN_FILE, "".join(lines).encode())


def is_same_fingerprint(fingerprint: str, other: str) -> bool:
    """Ignores case, spaces and dashes."""
    one, two = ("".join(filter(str.isalnum, text)).upper() for text in (fingerprint, other))
    return one == two
