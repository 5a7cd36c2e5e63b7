"""One server for all tests of the archive: to make and start one takes two seconds."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.records.archive_server import PASSWORD, ArchiveServer, archive_server

PAGE = Path(__file__).parents[3] / "docs" / "archive.md"


@pytest.fixture(scope="session")
def server() -> Iterator[ArchiveServer]:
    with archive_server() as one:
        yield one


@pytest.fixture(scope="module")
def url_of_stations(server: ArchiveServer) -> str:
    """Of the role for stations, in a database that is set up as docs/archive.md says."""
    block = re.search(r"```sql\n(.+?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert block is not None
    server.run("DROP DATABASE IF EXISTS dps_s", "DROP ROLE IF EXISTS dps_s_station")
    first, *rest = [line for line in block[1].split(";\n") if line.strip()]
    assert first.startswith("CREATE DATABASE dps_s")
    server.run(first)
    server.run(*(line.replace("a long password", PASSWORD) for line in rest if "\\connect" not in line),
               database="dps_s")  # fmt: skip
    return server.url("dps_s", "dps_s_station")
