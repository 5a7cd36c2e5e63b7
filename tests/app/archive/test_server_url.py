"""The address of a server, and what is shown of it."""

import pytest

from app.archive import postgres
from app.archive.server_url import server_url
from app.text.user_error import UserError
from tests.support.processes import ran_code


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
        ("postgresql://db/x?sslrootcert=/My%20Files/a+b", "postgresql://db/x?sslrootcert=%2FMy%20Files%2Fa%2Bb", ""),
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
@pytest.mark.promise("g")
def test_what_may_hide_a_password_is_refused_without_showing_it(typed: str) -> None:
    with pytest.raises(UserError) as caught:
        server_url(typed)
    assert "secret" not in str(caught.value)
    assert "cret@" not in str(caught.value)


def test_psycopg_is_loaded_only_for_a_server_and_its_absence_is_a_sentence() -> None:
    program = (
        "import sys, app.__main__, app.archive.postgres\n"
        "assert app.__main__.main(['archive', 'status']) == 0\n"
        "assert not {'psycopg', 'psycopg_binary', 'keyring'} & sys.modules.keys()\n"
        "sys.modules['psycopg'] = None\n"
        "sys.exit(app.__main__.main(['archive', 'sync', 'postgresql://db/x']))\n"
    )
    done = ran_code(program)
    assert done.returncode == 3
    assert 'pip install "dps-s-configurator[archive]"' in done.stderr


@pytest.mark.parametrize(
    ("attempts", "why"),
    [
        (["FATAL: wrong", "FATAL: wrong"], "FATAL: wrong"),
        (["FATAL: wrong", "FATAL: no entry"], "FATAL: wrong; FATAL: no entry"),
        (["fe_sendauth: no password supplied"], "no password was found for it"),
        (["SSL error: certificate verify failed"], "this computer does not trust its certificate"),
        (['root certificate file "x" does not exist\nEither provide the file, or change sslmode'],
         'root certificate file "x" does not exist'),
    ],
)  # fmt: skip
def test_each_reason_of_libpq_is_told_once(attempts: list[str], why: str) -> None:
    import psycopg  # 16 MB, only where it is used

    raw = "\n".join(f'connection to server at "db" (10.1.2.3), port 5432 failed: {attempt}' for attempt in attempts)
    trouble = postgres._trouble(server_url("postgresql://db/x"), psycopg.OperationalError(f"connection failed: {raw}"))
    assert str(trouble) == f"The archive server postgresql://db/x cannot be used: {why}"
