"""Checks and profiles for several modules, on in-process lines: each by itself, none waits for another."""

from pathlib import Path

import pytest

from app.engine.procedure import Cancelled, PortLost
from app.fleet.check_set import SetMember, check_set_target, summary, word_of, write_set_reports
from app.fleet.profile_table import Applied, AppliedProfile, broken_off, column, outcome_of, result_line, settings_in
from app.preflight.evidence import FrameLog
from app.preflight.findings import Person
from app.preflight.verdict import Verdict
from app.procedures.read import read_everything
from app.procedures.write_all import WriteContext, write_all
from app.records.filing import Filed, file_check
from app.records.report_files import record_in
from app.settings.profiles import NO_PROFILE, Match, Profile
from app.text.i18n import CHINESE, ENGLISH, set_language
from app.text.messages import message
from app.text.user_error import UserError
from protocol.catalogue import BAUD_RATE, BY_NAME
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import Rig
from tests.support.records.preflight_rig import check

PROFILE = Profile(
    name="Show",
    settings={"attitude_threshold_deg": 70, "freefall_time_s": 1.2, "attitude_trigger": True, "baud_rate": 9600},
)


def filed(**options: str) -> Filed:
    found = check(options=options)
    evidence = found.assessment.case.evidence
    return file_check(evidence, NO_PROFILE, Person(), FrameLog(), store=None, program_version="1")


def _printed(body: str, attached: bytes) -> bytes:
    return b"%PDF- " + body.encode() + b"\nstream\n" + attached + b"\nendstream"


def test_a_report_of_each_module_and_a_first_page(tmp_path: Path) -> None:
    members = (
        SetMember("/dev/a", "M-<1>", filed()),
        SetMember("/dev/b", "", filed(cell="3.4")),
        SetMember("/dev/c", "M-3", None, message("The module does not answer.")),
    )
    assert [one.verdict for one in members] == [Verdict.READY, Verdict.NO_GO, None]
    assert "Cell voltage" in members[1].why
    assert members[2].why == "The module does not answer."
    assert summary(members) == f"1 READY, 1 NO-GO, 1 {word_of(None)}"
    target = tmp_path / "set.pdf"
    check_set_target(target)
    written = write_set_reports(target, members, _printed)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in written)
    reports = [path for path in written if path.suffix == ".pdf" and path != target]
    records = [one.filed.record for one in members if one.filed is not None]
    assert [record_in(path.with_suffix(".json").read_bytes()) for path in reports] == records
    page = target.read_bytes()
    for words in ("M-&lt;1&gt;", "The module does not answer.", *(path.name for path in reports)):
        assert words.encode() in page
    with pytest.raises(UserError):  # a first page is no record
        record_in(page)
    check_set_target(target)  # our own is replaced
    other = tmp_path / "other.pdf"
    other.write_text("a thesis", encoding="utf-8")
    with pytest.raises(UserError):
        check_set_target(other)


def test_a_profile_is_compared_written_and_verified_on_each() -> None:
    rigs = {"a": Rig(), "b": Rig({"mute_codes": f"{BY_NAME['freefall_time'].code:02X}"}), "c": Rig({"active": "yes"})}
    results: dict[str, AppliedProfile] = {}
    for port, rig in rigs.items():
        rig.run(read_everything())
        table = column(PROFILE, rig.session.device.view(rig.clock()), rig.clock(), port=port, title=port)
        assert [one.command for one in table.rows] == list(settings_in(PROFILE))
        assert BAUD_RATE not in settings_in(PROFILE)
        assert {one.match for one in table.rows} <= {Match.DIFFERENT, Match.UNKNOWN}
        report = rig.run(write_all(table.changes, WriteContext(journal=FakeJournal())))
        results[port] = outcome_of(report)
    assert results["a"].state is Applied.ACKNOWLEDGED  # the trigger cannot be read back, and that is said
    assert tr_title("attitude_trigger") in results["a"].why
    assert results["b"].state is Applied.FAILED
    assert results["c"].state is Applied.REFUSED  # active: nothing is written
    set_language(CHINESE)
    assert results["a"].why.startswith("未回读：")
    assert results["c"].why == "模块已激活：请先锁定。"
    set_language(ENGLISH)
    assert result_line(results.values()) == "1 written, 1 refused, 1 FAILED"
    rig = rigs["a"]
    again = column(PROFILE, rig.session.device.view(rig.clock()), rig.clock(), port="a", title="a")
    assert [change.command.name for change in again.changes] == []


def tr_title(name: str) -> str:
    return BY_NAME[name].title


def test_what_was_broken_off_is_never_fine() -> None:
    for error in (PortLost(), Cancelled()):
        found = broken_off((), error)
        assert found.state is Applied.FAILED
        assert not found.state.is_fine
        assert "is unknown" in found.why
        set_language(CHINESE)
        assert "未知" in found.why
        set_language(ENGLISH)
