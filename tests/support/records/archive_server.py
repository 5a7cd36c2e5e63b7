"""Runs a private PostgreSQL server for the tests: on a Unix socket, and with TLS on a free TCP port."""

import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from ipaddress import ip_address
from pathlib import Path
from typing import Any

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID

OWNER = "postgres"
PASSWORD = "secret/of@the?test"
ROOT_CERTIFICATE = "root.crt"
WITH_PASSWORD = "guarded"
"""A role that needs `PASSWORD` over TCP."""


@dataclass(frozen=True)
class ArchiveServer:
    """A running server; its socket is in `folder`."""

    folder: Path
    port: int

    def url(self, database: str = "archive", user: str = OWNER) -> str:
        """Return the URL for the socket, which needs no password."""
        return f"postgresql://{user}@/{database}?host={self.folder}&port={self.port}"

    def tcp_url(self) -> str:
        return f"postgresql://{WITH_PASSWORD}@127.0.0.1:{self.port}/archive"

    def run(self, *statements: str, database: str = "archive") -> list[tuple[object, ...]]:
        """Execute statements as the owner; return the rows of the last one."""
        import psycopg

        with psycopg.connect(self.url(database), autocommit=True) as connection:
            for statement in statements:
                cursor = connection.execute(statement.encode())
            return cursor.fetchall() if cursor.description else []


@contextmanager
def archive_server() -> Iterator[ArchiveServer]:
    """Start a server with an empty database; stop and remove it at the end. Without one the test is skipped."""
    found = shutil.which("initdb")
    installed = sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True)
    places = [*([Path(found).resolve().parent] if found else []), *installed]
    programs = next((place for place in places if (place / "initdb").exists() and (place / "pg_ctl").exists()), None)
    if programs is None:
        pytest.skip("PostgreSQL is not installed: sudo apt-get install postgresql")
    folder = Path(tempfile.mkdtemp(prefix="dps-s-pg-"))
    data = folder / "data"
    who: dict[str, Any] = {}
    if os.geteuid() == 0:  # PostgreSQL refuses root
        import pwd

        names = {one.pw_name: one for one in pwd.getpwall()}
        user = names.get("postgres") or names["nobody"]
        os.chown(folder, user.pw_uid, user.pw_gid)
        who = {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}

    def run(program: str, *words: str) -> None:
        environment = {**os.environ, "LC_ALL": "C", "HOME": str(folder)}
        command = [str(programs / program), "-D", str(data), *words]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment, cwd=folder, **who)

    try:
        run("initdb", "-U", OWNER, "-A", "trust", "--no-sync", "-E", "UTF8", "--locale=C")
        (data / "pg_hba.conf").write_text("local all all trust\nhost all all 127.0.0.1/32 scram-sha-256\n", "utf-8")
        key = write_certificate(folder / ROOT_CERTIFICATE, data / "server.key")
        if who:
            os.chown(key, who["user"], who["group"])
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        options = {
            "ssl": "on", "ssl_cert_file": folder / ROOT_CERTIFICATE,
            "listen_addresses": "127.0.0.1", "port": port, "unix_socket_directories": folder, "fsync": "off",
            "shared_buffers": "16MB", "max_connections": 20, "autovacuum": "off", "jit": "off",
        }  # fmt: skip
        settings = "".join(f"{name} = '{value}'\n" for name, value in options.items())
        (data / "postgresql.auto.conf").write_text(settings, "utf-8")
        run("pg_ctl", "-w", "-l", str(folder / "log"), "start")
        try:
            server = ArchiveServer(folder, port)
            role = f"CREATE ROLE {WITH_PASSWORD} LOGIN SUPERUSER PASSWORD '{PASSWORD}'"
            server.run("CREATE DATABASE archive", role, database="postgres")
            yield server
        finally:
            run("pg_ctl", "-w", "-m", "fast", "stop")
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def write_certificate(target: Path, key_target: Path) -> Path:
    """Write a self-signed certificate for 127.0.0.1, which is also its root; return the path of the key."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "hangar")])
    now, day = datetime.now(UTC), timedelta(days=1)
    made = (
        x509.CertificateBuilder(name, name, key.public_key(), x509.random_serial_number(), now - day, now + day)
        .add_extension(x509.SubjectAlternativeName([x509.IPAddress(ip_address("127.0.0.1"))]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    target.write_bytes(made.public_bytes(Encoding.PEM))
    key_target.write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
    key_target.chmod(0o600)
    return key_target
