"""What people did to a module, and what is due again."""

from datetime import date, timedelta

import pytest

from app.limits.service import Service, ServiceKind, due_services, service_of
from app.text.user_error import UserError

TODAY = date(2026, 11, 24)


def repacked(due: date | None, on: date = date(2026, 5, 24)) -> dict[str, object]:
    return Service(kind=ServiceKind.REPACK, on=on, due=due, who="Li Wei", note="\x1b[2J").content()


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
    content = repacked(None if days is None else TODAY + timedelta(days=days))
    due = due_services([content], TODAY)
    assert [(service.text.in_english(), service.is_overdue) for service in due] == said


def test_the_last_of_each_kind_counts() -> None:
    late = repacked(date(2026, 11, 1))
    cell = {**late, "service": "cell"}
    unreadable = [{**late, "service": "balloon"}, {**late, "due": "soon"}]
    assert len(due_services([late, cell], TODAY)) == 2
    assert due_services([late, cell, *unreadable, repacked(None), {**cell, "due": "2030-01-01"}], TODAY) == []


def test_it_reads_as_it_was_kept() -> None:
    service = service_of(repacked(date(2026, 12, 6)))
    assert (service.kind, service.on, service.due) == (ServiceKind.REPACK, date(2026, 5, 24), date(2026, 12, 6))
    assert service.summary().in_english() == "Repack on 2026-05-24 by Li Wei, due again: 2026-12-06. [U+001B][2J"
    with pytest.raises(UserError, match="cannot be due"):
        repacked(TODAY, on=TODAY)
