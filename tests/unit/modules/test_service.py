"""What people did to a module, and what of it is due again."""

from datetime import date, timedelta

import pytest

from app.modules.service import ServiceKind, all_due, repack_due, service_summary, serviced
from app.store.fact_store import Kept
from app.store.rows import Row, Serviced
from app.text.messages import UserError

TODAY = date(2026, 11, 24)


def kept(content: Serviced, at: str = "2026-05-24T12:00:00.000000+00:00") -> Kept[Serviced]:
    return Kept(Row("0" * 40, "service", "M-07", "a" * 64, at, "{}"), content)


def repacked(due: date | None, on: date = date(2026, 5, 24), kind: ServiceKind = ServiceKind.REPACK) -> Serviced:
    return serviced(kind, on=on, due=due, who="Li Wei", note="\x1b[2J")


@pytest.mark.parametrize(
    ("days", "said"),
    [
        (31, []),
        (30, [("Repack due on 2026-12-24, days left: 30.", False)]),
        (0, [("Repack due on 2026-11-24, days left: 0.", False)]),
        (-1, [("Repack overdue since 2026-11-23.", True)]),
        (None, []),
    ],
)
def test_what_is_due_is_said_in_time(days: int | None, said: list[tuple[str, bool]]) -> None:
    one = repacked(None if days is None else TODAY + timedelta(days=days))
    due = all_due(None, [kept(one)], TODAY)
    assert [(service.text.in_english(), service.is_overdue) for service in due] == said


def test_the_last_of_each_kind_counts_and_none_of_a_day_to_come() -> None:
    late, cell = repacked(date(2026, 11, 1)), repacked(date(2026, 11, 1), kind=ServiceKind.CELL)
    assert len(all_due(None, [kept(late), kept(cell)], TODAY)) == 2
    again = [repacked(None), repacked(date(2030, 1, 1), kind=ServiceKind.CELL)]
    assert all_due(None, [*map(kept, (late, cell, *again))], TODAY) == []
    tomorrow = repacked(None, on=TODAY + timedelta(days=1))
    assert len(all_due(None, [kept(late), kept(tomorrow)], TODAY)) == 1


@pytest.mark.promise("f")
def test_what_may_have_fired_needs_a_repack_that_was_entered_afterwards() -> None:
    fired = "2026-11-20T10:00:00.000000+00:00"
    assert repack_due(None) is None
    due = repack_due(fired)
    assert due is not None
    assert due.is_after_firing
    before = kept(repacked(None, on=date(2026, 11, 20)), at="2026-11-20T09:00:00.000000+00:00")
    backdated = kept(repacked(None, on=date(2026, 11, 18)), at="2026-11-21T09:00:00.000000+00:00")
    cell = kept(repacked(None, on=date(2026, 11, 21), kind=ServiceKind.CELL), at="2026-11-21T09:00:00.000000+00:00")
    assert repack_due(fired, [before, backdated, cell]) is not None
    done = kept(repacked(None, on=date(2026, 11, 21)), at="2026-11-21T09:00:00.000000+00:00")
    assert repack_due(fired, [done]) is None


def test_it_is_told_as_it_was_kept() -> None:
    told = service_summary(repacked(date(2026, 12, 6))).in_english()
    assert told == "Repack on 2026-05-24 by Li Wei, due again: 2026-12-06. [U+001B][2J"
    assert service_summary(serviced(ServiceKind.CELL, on=TODAY)).in_english() == (
        "Cell on 2026-11-24 by not named, due again: never."
    )
    with pytest.raises(UserError, match="on a later day"):
        repacked(TODAY, on=TODAY)
