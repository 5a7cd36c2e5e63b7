"""The address of a server, and what is shown of it."""

import pytest

from app.archive.places import server_url
from app.text.messages import UserError
from tests.support.processes import ran_code


@pytest.mark.parametrize(
    ("typed", "shown", "password"),
    [
        (
            "postgresql://li:p%40ss@db.example:5433/dps_s?sslmode=verify-full",
            "postgresql://li@db.example:5433/dps_s?sslmode=verify-full",
            "p@ss",
        ),
        ("postgres://db/dps_s", "postgresql://db/dps_s", ""),
        ("postgresql://db/x?sslrootcert=/My%20Files/a+b", "postgresql://db/x?sslrootcert=/My%20Files/a+b", ""),
        ("postgresql://:secret@[::1]/x", "postgresql://[::1]/x", "secret"),
    ],
)
def test_the_password_is_taken_out(typed: str, shown: str, password: str) -> None:
    url = server_url(typed)
    assert (url.shown, url.password) == (shown, password)
    assert server_url(url.shown) == url._replace(password="")


@pytest.mark.parametrize(
    "typed",
    [
        "db",
        "host=db password=secret",
        "postgresql://li:a@secret@db/x",
        "postgresql://li:se/cret@db/x",
        "postgresql://" + "secret" * 1000,
        "postgresql://li@db/x?PassWord=secret",
        "postgresql://li@db/x?%70assword=secret",
        "postgresql://li@db/x?scram_client_key=secret",
    ],
)
@pytest.mark.promise("g")
def test_what_may_hide_a_password_is_refused_without_showing_it(typed: str) -> None:
    with pytest.raises(UserError) as caught:
        server_url(typed)
    assert "secret" not in str(caught.value)
    assert "cret@" not in str(caught.value)


def test_psycopg_is_loaded_only_for_a_server_and_its_absence_is_a_sentence() -> None:
    program = (
        "import sys, app.__main__, app.archive.places\n"
        "assert app.__main__.main(['archive', 'status']) == 0\n"
        "assert not {'psycopg', 'psycopg_binary'} & sys.modules.keys()\n"
        "sys.modules['psycopg'] = None\n"
        "sys.exit(app.__main__.main(['archive', 'sync', 'postgresql://db/x']))\n"
    )
    done = ran_code(program)
    assert done.returncode == 3
    assert 'pip install "dps-s-configurator[archive]"' in done.stderr
