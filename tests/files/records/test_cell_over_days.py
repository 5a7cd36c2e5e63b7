"""When the cell was charged last, as far as the checks tell."""

from datetime import UTC, datetime, timedelta

import pytest

from app.records.filing import weeks_since_charge

START = datetime(2026, 3, 1, tzinfo=UTC)


@pytest.mark.parametrize(
    ("measured", "weeks"),
    [
        ([], None),
        ([(0, 4.0)], None),
        ([(0, 4.0), (30, 3.9)], None),  # it never rose
        ([(0, 3.8), (2, 4.16), (13, 4.1), (23, 3.9)], 3),
        ([(0, 3.8), (2, 4.16), (9, 4.1), (16, 4.12), (30, 4.1)], 4),  # a reading scatters
        ([(0, 3.8), (2, 4.16), (9, 4.1), (16, 4.16), (30, 4.1)], None),  # or it was charged a little
        ([(0, 3.8), (2, 4.16), (30, 4.1)], None),  # or in between
        ([(0, 3.8), (2, 4.16), (14, 4.0), (16, 4.16), (30, 4.0)], 2),  # the last charge
        ([(0, 3.8), (20, 4.16), (40, 4.0)], None),  # some day of three weeks
        ([(0, 3.8), (2, 4.16), (4, 4.1)], None),  # days, not weeks
    ],
)
def test_the_last_charge_is_told_only_where_the_checks_tell_it(
    measured: list[tuple[int, float]], weeks: int | None
) -> None:
    assert weeks_since_charge([(START + timedelta(days=day), volts) for day, volts in measured]) == weeks
