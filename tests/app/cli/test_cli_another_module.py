"""Another module takes the place of the first one in the middle of a command."""

import json
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.settings.profile_file import read_profile
from app.simulator.memory import invent_records
from app.store.fact_store import Facts, Store
from app.store.kinds import ModuleProvisioned
from protocol.catalogue import BY_NAME, STATUS_CODE, Request
from tests.adversary.program import PORT, Ran, Stage, write_at_once
from tests.app.cli.test_cli_act import recorded
from tests.support.cli_line import Program, bench_of, exchange, falls_after, falls_behind
from tests.support.line.lies import lying_bench
from tests.support.line.sim_line import FakeClock
from tests.support.records.stored import modules_in, open_store

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "no_waiting")


@pytest.fixture
def stage(user_files: Path) -> Stage:
    """The command line and a module in one thread, on a clock that only waiting moves."""
    clock = FakeClock()
    return Stage(lying_bench({}, clock), clock, user_files)


def run(stage: Stage, words: list[str], code: int = 0) -> Ran:
    ran = stage.run([words[0], "--port", PORT, *words[1:]])
    assert (ran.code, ran.mishaps) == (code, []), ran.err
    return ran


@pytest.mark.parametrize("frame", [5, 8, 10])
@pytest.mark.promise("a")
def test_values_of_two_modules_are_not_read_as_those_of_one(stage: Stage, frame: int) -> None:
    bench = stage.bench
    with falls_after(bench, frame, lambda: exchange(bench, light_threshold=70)):
        shown = json.loads(run(stage, ["read", "--json"]).out)
    settings = shown["settings"]
    assert (shown["boot_count"], settings["attitude_threshold_deg"], settings["light_threshold_v"]) == (90, 85, 7.0)


@pytest.mark.parametrize("frame", [5, 10])
def test_what_a_module_does_not_answer_is_not_taken_from_the_one_before(stage: Stage, frame: int) -> None:
    bench = stage.bench
    with (
        falls_after(bench, frame, lambda: bench.change(mute_codes=frozenset({BY_NAME["light"].code}))),
        falls_after(bench, frame, lambda: exchange(bench)),
    ):
        shown = json.loads(run(stage, ["read", "--json"], 4).out)
    assert (shown["boot_count"], shown["light_v"]) == (90, None)


@pytest.mark.parametrize("ends", ["unplugged", "silent"])
@pytest.mark.parametrize("frame", [11, 13])
def test_values_of_two_modules_are_not_read_as_those_of_one_where_reading_ends_then(
    ends: str, frame: int, port: str, dps_s: Program
) -> None:
    bench = bench_of(port)
    with (
        falls_after(bench, frame, bench.unplug if ends == "unplugged" else lambda: bench.change(mute=True)),
        falls_after(bench, 7, lambda: exchange(bench, light_threshold=70)),
    ):
        shown = json.loads(dps_s(["read", "--port", port, "--json"], 4).out)
    settings = shown["settings"]
    assert (settings["light_threshold_v"], settings["attitude_threshold_deg"]) == (None, 85)
    assert "light_threshold_v" in shown["errors"]


@pytest.mark.parametrize("gap_s", [1.2, 1.3, 1.4])
def test_what_answers_when_the_module_counts_as_silent_is_not_printed_as_its_status(
    stage: Stage, gap_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While the stream is switched off another one comes."""
    bench = stage.bench
    monkeypatch.setattr("tests.support.cli_line.GAP_S", gap_s)

    def fall() -> None:
        exchange(bench)
        bench.world.tilt_deg = 33.0
        monkeypatch.setattr(bench.wire, "write", lambda *_: None)  # it streams, and "off" was for the first one

    with falls_after(bench, 20, fall):
        shown = run(stage, ["monitor", "--json"], 3).out
    assert {json.loads(line)["tilt_deg"] for line in shown.splitlines()} == {0}
    assert stage.truth.heard[STATUS_CODE][-1].raw[3] == 33


@pytest.mark.parametrize("frame", [6, 8, 10, 12])
def test_no_profile_is_saved_with_settings_of_two_modules(stage: Stage, frame: int, tmp_path: Path) -> None:
    """Their boot count is the same."""
    bench = stage.bench
    with falls_after(bench, frame, lambda: exchange(bench, boot_count=37, light_threshold=70)):
        run(stage, ["save", str(tmp_path / "H6.toml")])
    saved = read_profile(tmp_path / "H6.toml").settings
    assert (saved["attitude_threshold_deg"], saved["light_threshold_v"]) == (85, 7.0)


def test_a_reading_that_ends_in_silence_is_not_whole(stage: Stage) -> None:
    """Everything was read, after a silence in between, and is read once more."""
    bench = stage.bench
    with (
        falls_after(bench, 14, lambda: bench.change(mute=True)),
        falls_after(bench, 5, lambda: exchange(bench, boot_count=37, attitude_threshold=60)),
    ):
        printed = run(stage, ["read", "--json"], 4)
    assert "The module does not answer." in printed.err
    assert json.loads(printed.out)["settings"]["attitude_threshold_deg"] == 60


@pytest.mark.parametrize("frame", [1, 2])
@pytest.mark.promise("a")
def test_of_a_module_that_was_activated_nobody_says_that_it_is_locked(stage: Stage, frame: int) -> None:
    """What answers then is another one, which is locked."""
    bench = stage.bench

    def leave_active() -> None:
        assert bench.module.state.is_active
        bench.module.activate(is_active=False)
        exchange(bench)

    with falls_behind(bench, REQUESTS[Act.ACTIVATE], frame, leave_active):
        printed = run(stage, ["activate", "--yes"], 1)
    assert printed.err == "Sent, not confirmed: treat the module as ACTIVE.\n"


@pytest.mark.parametrize("gap_s", [3.5, 8.0])
@pytest.mark.parametrize("frame", [2, 7])
@pytest.mark.parametrize("words", [["activate", "--yes"], ["shutdown", "--yes"], ["set", "attitude_trigger=true"]])
def test_what_answers_long_after_the_first_one_fell_silent_gets_nothing(
    words: list[str], frame: int, gap_s: float, stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was asked on, and the one that was plugged in meanwhile was activated."""
    monkeypatch.setattr("tests.support.cli_line.GAP_S", gap_s)
    with falls_after(stage.bench, frame, lambda: exchange(stage.bench, attitude_threshold=60)):
        run(stage, words, 3)
    assert not stage.truth.acts_sent


@pytest.mark.parametrize(("frame", "option"), [(1, []), (2, []), (2, ["--same-module"])])
def test_after_a_silence_lock_is_said_of_the_module_that_answers_now(
    stage: Stage, frame: int, option: list[str]
) -> None:
    """It is another one, which is locked, and the first one may not have heard it: of that nothing is confirmed."""
    bench = stage.bench
    with falls_after(bench, frame, lambda: exchange(bench)):
        printed = run(stage, ["lock", "--yes", *option])
    assert printed.out == "The module that answers now reports LOCKED.\n"
    assert recorded() == [(Act.LOCK, Outcome.UNKNOWN)]


def test_a_slow_line_is_no_silence(stage: Stage) -> None:
    stage.bench.change(delay_ms=400.0)
    assert run(stage, ["lock", "--yes"]).out == "The module reports LOCKED.\n"


@pytest.mark.parametrize(
    ("words", "frames", "gap_s"),
    [
        ("set attitude_threshold_deg=75", (8, 14, 18), 0.5),
        ("activate --yes", (4, 15, 36, 44), 0.5),
        ("zero --yes", (20, 75, 84), 0.5),
        ("shutdown --yes", (14, 35, 44), 0.5),
        ("preflight --enable-triggers", (25, 40, 50, 72, 73, 90, 111, 115), 0.5),
        # Else taken for a slow line, on which too little time is left to read again what tells another module.
        *((words, (14,), gap_s) for words in ("shutdown --yes", "set baud_rate=57600") for gap_s in (0.36, 0.44)),
    ],
)
@pytest.mark.promise("a")
def test_nothing_is_sent_to_another_module_than_was_read(
    stage: Stage, words: str, frames: tuple[int, ...], gap_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tests.support.cli_line.GAP_S", gap_s)
    for frame in frames:
        stage = Stage(lying_bench({}, stage.clock), stage.clock, stage.home)
        with falls_after(stage.bench, frame, partial(exchange, stage.bench)):
            printed = run(stage, words.split(), 1)
        assert not stage.truth.acts_sent, frame
        assert "--yes" not in words or printed.err.startswith("Nothing was sent. ")
    assert {outcome for _, outcome in recorded()} <= {Outcome.NOT_SENT}  # after the intent was logged


@pytest.mark.parametrize("boots", [37, 90])
@pytest.mark.parametrize("frame", [20, 34, 44])
def test_of_a_module_that_was_written_nobody_says_what_another_one_holds(stage: Stage, frame: int, boots: int) -> None:
    """What answers then, or after the settings have settled, is another one."""
    bench = stage.bench
    with falls_after(bench, frame, lambda: exchange(bench, boot_count=boots, light_threshold=70)):
        shown = json.loads(run(stage, ["set", "attitude_threshold_deg=75", "--json"], 1).out)
    written = shown["results"]["attitude_threshold_deg"]
    assert (written["read_back"], bool(written["verified"]), shown["changed"]) == (None, False, {})
    assert recorded() == [(Act.WRITE, Outcome.UNKNOWN)]


@pytest.mark.parametrize("frame", [18, 19, 20, 23, 27])
def test_a_setting_that_was_not_sent_still_tells_another_module(stage: Stage, frame: int) -> None:
    """Nothing else differs."""
    bench = stage.bench
    with falls_after(bench, frame, lambda: exchange(bench, boot_count=37)):
        shown = json.loads(run(stage, ["set", "freefall_time_s=1.7", "attitude_threshold_deg=75", "--json"], 1).out)
    assert shown["results"]["attitude_threshold_deg"]["error"].startswith("not sent: ")
    assert (shown["results"]["freefall_time_s"]["verified"], shown["changed"]) == (False, {})


def test_what_is_set_aside_of_a_batch_has_no_settings_of_another_module(stage: Stage, tmp_path: Path) -> None:
    profile = tmp_path / "batch.toml"
    profile.write_text('name = "x"\n[settings]\nfreefall_time_s = 1.2\n', encoding="utf-8")
    words = ["provision", "--profile", str(profile), "--names", "M-001", "--enable-triggers", "--records-reviewed"]
    with falls_after(stage.bench, 70, lambda: exchange(stage.bench)):
        run(stage, [*words, "--yes"])
    with closing(open_store()) as store:
        aside, ready = (kept.content for kept in store.read(lambda facts: facts.of_kind(ModuleProvisioned)))
    assert (aside.boot_count, aside.code, ready.boot_count) == (37, "", 90)


@pytest.mark.promise("a")
def test_a_check_that_met_two_modules_tells_nothing_of_the_named_one(stage: Stage) -> None:
    bench = stage.bench
    words = ["preflight", "--who", "R. Tanaka", "--module", "M-07", "--json"]
    with falls_after(bench, 8, lambda: exchange(bench)):
        met = json.loads(run(stage, words, 1).out)
    assert met["read"]["boot_count"] == 90
    bench.module.memory.boot_count, bench.module.memory.attitude_threshold = 37, 60
    checks = {one["id"]: one for one in json.loads(run(stage, words, 1).out)["checks"]}
    assert checks["undisturbed"]["result"] == "pass"
    assert checks["boot_count"]["result"] == "warn", checks["boot_count"]


@pytest.mark.parametrize("frame", [10, 41, 43, 60, 83, 100, 116, 126])
def test_a_check_shows_no_value_of_one_module_beside_settings_of_another(stage: Stage, frame: int) -> None:
    bench = stage.bench

    def fall() -> None:
        exchange(bench, light_threshold=70)
        bench.world.cell_v = 4.1

    with falls_after(bench, frame, fall):
        read = json.loads(run(stage, ["preflight", "--who", "R. Tanaka", "--json"], 1).out)["read"]
    settings, cell_v = read["settings"], read["cell_voltage_v"]
    shown = (read["boot_count"], settings["light_threshold_v"], settings["attitude_threshold_deg"], cell_v)
    assert all(value in (None, another) for value, another in zip(shown, (90, 7.0, 85, 4.1), strict=True)), shown


@pytest.mark.parametrize("ends", ["unplugged", "silent"])
@pytest.mark.parametrize(("frame", "ends_at"), [(50, 75), (64, 70), (68, 72)])
def test_a_check_that_ends_after_an_exchange_shows_no_value_of_one_module_beside_settings_of_another(
    stage: Stage, frame: int, ends_at: int, ends: str
) -> None:
    """It ends before the settings are read again."""
    bench = stage.bench

    def fall() -> None:
        exchange(bench)
        bench.world.cell_v = 4.1

    with (
        falls_after(bench, ends_at, bench.unplug if ends == "unplugged" else lambda: bench.change(mute=True)),
        falls_after(bench, frame, fall),
    ):
        read = json.loads(run(stage, ["preflight", "--who", "R. Tanaka", "--json"], 1).out)["read"]
    assert None in (read["cell_voltage_v"], read["settings"]["attitude_threshold_deg"])


@pytest.mark.parametrize(
    ("words", "first", "frames"),
    [
        ("preflight --enable-triggers", BY_NAME["freefall_trigger"].set(True), (2, 30, 61, 64)),
        ("set attitude_trigger=true freefall_trigger=true", BY_NAME["freefall_trigger"].set(True), (2, 30, 102, 105)),
        ("set attitude_threshold_deg=75 baud_rate=57600", BY_NAME["attitude_threshold"].set(75), (2, 29, 33)),
    ],
)
def test_the_second_set_is_not_sent_to_another_module_than_the_first(
    stage: Stage, words: str, first: Request, frames: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It takes its place after the first one was acknowledged, up to the last question before the second one."""
    monkeypatch.setattr("tests.support.cli_line.GAP_S", 0.36)
    for frame in frames:
        stage = Stage(lying_bench({}, stage.clock), stage.clock, stage.home)
        with falls_behind(stage.bench, first, frame, partial(exchange, stage.bench)):
            run(stage, words.split(), 1)
        assert stage.truth.acts_sent.total() == 1, frame


@pytest.mark.parametrize("words", [["activate", "--yes"], ["set", "light_threshold_v=2.0"], ["set", "baud_rate=57600"]])
def test_nothing_is_sent_to_another_module_that_came_while_the_disk_was_slow(
    stage: Stage, words: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their boot counts are the same."""

    def write_slowly(store: Store, work: Callable[[Facts], object]) -> "Future[object]":
        future, ends_at_s = write_at_once(store, work), stage.clock() + 0.8
        monkeypatch.setattr(future, "done", lambda: stage.clock() >= ends_at_s)
        return future

    monkeypatch.setattr("tests.adversary.program.write_at_once", write_slowly)
    stage.happens_at(stage.clock() + 0.3, lambda bench: exchange(bench, boot_count=37))
    run(stage, words, 1)
    assert not stage.truth.acts_sent


@pytest.mark.parametrize("more", [[], ["--module", "M-07"]])
@pytest.mark.parametrize("frame", [15, 38])
@pytest.mark.promise("a")
def test_records_of_two_modules_are_not_read_as_those_of_one(stage: Stage, frame: int, more: list[str]) -> None:
    """What came is listed, as incomplete, and nothing is kept."""
    bench, words = stage.bench, ["history", "--json", *more]
    memory = bench.module.memory
    invent_records(memory, 3, seed=5)
    before = [*memory.records]

    def exchange_records() -> None:
        exchange(bench)
        memory.records.clear()
        invent_records(memory, 2, seed=9)

    with falls_after(bench, frame, exchange_records):
        printed = run(stage, words, 4)
    assert printed.err == "The module restarted. Read again.\n"
    listed = json.loads(printed.out)
    assert (bool(listed["records"]), listed["complete"]) == (True, False)
    memory.boot_count, memory.attitude_threshold = 37, 60
    memory.records.clear()
    memory.records.extend(before)
    run(stage, words)


@pytest.mark.parametrize("frame", [15, 16])
def test_nothing_is_kept_of_two_modules_that_only_their_records_tell_apart(stage: Stage, frame: int) -> None:
    """While the last records of the first one are waited for, another one takes its place."""
    bench, memory = stage.bench, stage.bench.module.memory
    invent_records(memory, 3, seed=5)

    def exchange_records() -> None:
        memory.records.clear()
        invent_records(memory, 2, seed=9)

    words = ["history", "--json", "--module", "M-07"]
    with falls_after(bench, frame, exchange_records):
        printed = run(stage, words, 4)
    assert "This may be another module: readings differ." in printed.err
    assert len(json.loads(printed.out)["records"]) == 5
    run(stage, words)


def test_nothing_is_kept_of_two_modules_where_the_port_is_lost_then(port: str, dps_s: Program) -> None:
    bench, words = bench_of(port), ["history", "--port", port, "--json", "--module", "M-07"]
    invent_records(bench.module.memory, 3, seed=5)
    with falls_after(bench, 20, lambda: exchange(bench)), falls_after(bench, 34, bench.unplug):
        printed = dps_s(words, 4)
    assert json.loads(printed.out)["records"]
    assert "unplugged" in printed.err
    with closing(open_store()) as store:
        assert modules_in(store) == ()
