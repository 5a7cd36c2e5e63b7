"""Makes stations that sign records."""

from functools import cache

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from app.store.station import Station


@cache
def station(name: str = "hangar") -> Station:
    """Return the station of this name; its key lasts for the test run."""
    private = Ed25519PrivateKey.generate()
    return Station(private.public_key().public_bytes_raw().hex(), private)
