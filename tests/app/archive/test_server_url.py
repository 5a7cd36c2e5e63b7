"""The address of a server, and what is shown of it."""

import subprocess
import sys

import pytest

from app.archive.fact_set import ArchiveTrouble
from app.archive.server_url import server_url
from tests.support.processes import ENVIRONMENT, ROOT


@pytest.mark.parametrize(
    ("typed", "shown", "password"),
    [
        ("postgresql://li:p%40ss@db.example:5433/dps_s?sslmode=verify-full",
         "postgresql://li@db.example:5433/dps_s?sslmode=verify-full", "p@ss"),
        ("postgres://db/dps_s", "postgresql://db/dps_s", ""),
        ("postgresql:///?service=hangar", "postgresql:///?service=hangar", ""),
        ("postgresql://li@db/x?password=secret&sslpassword=s2&sslkey=k", "postgresql://li@db/x?sslkey=k", ""),
        ("postgresql://li@db/x?PassWord=secret", "postgresql://li@db/x", ""),
        ("postgresql://li@db/x?%70assword=secret", "postgresql://li@db/x", ""),
        ("postgresql://:secret@[::1]/x", "postgresql://[::1]/x", "secret"),
    ],
)  # fmt: skip
def test_the_password_is_taken_out(typed: str, shown: str, password: str) -> None:
    url = server_url(typed)
    assert (url.shown, url.password) == (shown, password)
    assert "secret" not in url.shown
    assert server_url(url.shown).shown == url.shown
    assert "secret" not in url.scrubbed("FATAL: secret, s2 and p@ss or p%40ss") or "secret" not in typed


@pytest.mark.parametrize(
    "typed",
    ["", "db", "sqlite://x", "host=db password=secret", "postgresql://li:a@secret@db/x", "postgresql://li:se/cret@db/x",
     "postgresql://li:se?cret@db/x", "postgresql://li:se#cret@db/x", "postgresql://" + "secret" * 1000],
)  # fmt: skip
def test_what_may_hide_a_password_is_refused_without_showing_it(typed: str) -> None:
    with pytest.raises(ArchiveTrouble) as caught:
        server_url(typed)
    assert "secret" not in str(caught.value)
    assert "cret@" not in str(caught.value)


def test_psycopg_is_loaded_only_for_a_server_and_its_absence_is_a_sentence() -> None:
    program = (
        "import sys, app.archive.postgres, app.archive.collection\n"
        "assert not {'psycopg', 'keyring'} & sys.modules.keys()\n"
        "sys.modules['psycopg'] = None\n"
        "from app.archive.fact_set import ArchiveTrouble\n"
        "try:\n    app.archive.postgres.open_server('postgresql://db/x')\n"
        "except ArchiveTrouble as error:\n    print(error)\n"
    )
    ran = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=ENVIRONMENT, capture_output=True, text=True,
                         check=True)  # fmt: skip
    assert 'pip install "dps-s-configurator[archive]"' in ran.stdout
