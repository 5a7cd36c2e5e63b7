"""The system's trusted root certificates as a file, because psycopg's bundled OpenSSL does not find them."""

import ssl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

ROOT_FILES: Final = (
    Path("/etc/ssl/certs/ca-certificates.crt"),  # Debian, Ubuntu, Arch
    Path("/etc/pki/tls/certs/ca-bundle.crt"),  # Fedora
    Path("/etc/ssl/ca-bundle.pem"),  # openSUSE
    Path("/etc/ssl/cert.pem"),  # macOS
)


@contextmanager
def system_roots() -> Iterator[Path | None]:
    """None if none are found. On Windows a temporary file is written and deleted at the end."""
    found = next((one for one in ROOT_FILES if one.is_file()), None)
    trusted = [] if found is not None else ssl.create_default_context().get_ca_certs(binary_form=True)
    if not trusted:
        yield found
        return
    with TemporaryDirectory(prefix="dps-s-") as folder:
        written = Path(folder, "roots.pem")
        written.write_text("".join(map(ssl.DER_cert_to_PEM_cert, trusted)), encoding="ascii")
        yield written
