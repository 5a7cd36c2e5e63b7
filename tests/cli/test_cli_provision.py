"""`dps-s provision`: a batch of modules, one after the other at one port."""

import signal
from collections.abc import Callable, Iterable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from app.cli.commands import BY_NAME
from app.modules.names import modules, remember
from app.port_urls.protocol_sim import open_bench
from app.simulator.bench import SimulatedBench
from app.simulator.module import Memory
from app.store.fact_store import Facts, StoreError
from app.store.rows import Content, ModuleProvisioned, Row
from app.terminal import console
from app.terminal.console import Refused
from tests.support.cli_line import run_here, sets
from tests.support.line.frames import at_frame, refuse
from tests.support.records.stored import checks_of, open_store
from tests.support.thorough import some

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "no_waiting", "qapp")  # it prints
SETTINGS = "attitude_threshold_deg = 65\nfreefall_time_s = 1.4\n"
Plug = Callable[[SimulatedBench], object]
Batch = Callable[..., list[str]]


def new(boots: int, then: Plug = lambda bench: None) -> Plug:
    """Another module, as it comes from the vendor."""

    def plug(bench: SimulatedBench) -> None:
        bench.module.memory = Memory(boot_count=boots - 1, records=bench.module.memory.records)
        bench.restart()
        then(bench)

    return plug


def active(bench: SimulatedBench) -> None:
    bench.module.activate(is_active=True)


def stop(_bench: SimulatedBench) -> None:
    signal.raise_signal(signal.SIGINT)


@pytest.fixture
def batch(monkeypatch: pytest.MonkeyPatch, port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Batch:
    """Runs a batch of M-001 and M-002, plugs in the next of `plugs` each time a person is told to; its lines."""
    write, notify = console.write_lines, console.notify

    def run(
        *words: str,
        plugs: Iterable[Plug] = (),
        code: int = 0,
        profile: str = SETTINGS,
        at: str = "",
        act: Callable[[], object] = bool,
    ) -> list[str]:
        left, lines = iter(plugs), list[str]()
        (tmp_path / "p.toml").write_text(f"format = 1\nname = 'Survey'\n[settings]\n{profile}", encoding="utf-8")

        def read(said: Iterable[console.Line]) -> None:
            said = list(said)
            lines.extend(line if isinstance(line, str) else line[0] for line in said)
            write(said)

        def hear(told: str) -> None:
            lines.append(told)
            notify(told)
            if " ".join(lines).endswith(at):
                act()
            if told == "UNPLUG, NEXT":
                next(left)(open_bench(port))

        monkeypatch.setattr(console, "write_lines", read)
        monkeypatch.setattr(console, "notify", hear)
        names = [] if "--names" in words else ["--names", "M-001..M-002"]
        run_here(capsys, ["provision", "-p", port, "--profile", str(tmp_path / "p.toml"), *names, *words], code)
        assert next(left, None) is None, "not everything was plugged in"
        return lines

    return run


ALLOWED = ("--yes", "--enable-triggers", "--records-reviewed")


def _verdicts(module: str | None) -> list[str]:
    with closing(open_store()) as store:
        return [check.verdict for check in checks_of(store, module)]


@pytest.mark.promise("i")
def test_a_batch_names_what_is_ready_and_sets_aside_what_is_not(
    batch: Batch, tmp_path: Path, port: str, wire: list[bytes]
) -> None:
    open_bench(port).module.memory.boot_count = 4
    files = ("--labels", str(tmp_path / "labels.pdf"), "--who", "Li Wei")
    again = lambda bench: bench.restart()  # noqa: E731  the same module, plugged in once more
    dark = lambda bench: bench.set_world(bay_is_open=True)  # noqa: E731
    lines = batch(
        *ALLOWED,
        *files,
        plugs=[again, new(3, active), new(2, dark), new(7, lambda bench: bench.set_world(bay_is_open=False))],
        profile=SETTINGS + "baud_rate = 9600\n",  # which stays as it is
    )
    assert [line for line in lines if line.startswith("PLUG IN")] == ["PLUG IN: M-001", *["PLUG IN: M-002"] * 4]
    aside = [line for line in lines if line.startswith("SET ASIDE:")]
    assert aside[0] == "SET ASIDE: It may be M-001: boot count and settings fit."
    assert aside[1] == "SET ASIDE: The module is ACTIVE: lock it first."
    assert aside[2].startswith("SET ASIDE: ")
    assert (len(aside), sets(wire)) == (
        3,
        ["attitude_threshold", "freefall_time", "freefall_trigger", "attitude_trigger"] * 3,
    )
    assert (_verdicts("M-001"), _verdicts("M-002"), _verdicts(None)) == (["READY"], ["READY"], ["NO-GO"])
    assert (tmp_path / "labels.pdf").read_bytes().startswith(b"%PDF-")
    with closing(open_store()) as store:
        assert {known.name: known.boot_count for known in store.read(modules)} == {"M-001": 4, "M-002": 7}


@pytest.mark.parametrize("boots", [5, 20])
def test_all_new_is_every_module_but_the_one_that_was_just_named(batch: Batch, port: str, boots: int) -> None:
    def used(bench: SimulatedBench) -> None:
        """Its settings are those of the batch, and its boot count may be that of M-001, or beyond that of M-002."""
        bench.module.memory.boot_count = boots
        bench.restart()

    open_bench(port).module.memory.boot_count = 4
    plugs = [SimulatedBench.restart, new(8), SimulatedBench.restart, used]
    lines = batch(*ALLOWED, "--all-new", "--names", "M-001..M-003", plugs=plugs)
    known = "SET ASIDE: It may be {}: boot count and settings fit."
    assert [line for line in lines if line.startswith("SET ASIDE:")] == [known.format("M-001"), known.format("M-002")]
    assert (_verdicts("M-002"), _verdicts("M-003")) == (["READY"], ["READY"])
    # The last one is not unplugged; the next batch does not take it for one of its own.
    lines = batch(*ALLOWED, "--all-new", "--names", "N-001", plugs=[stop], code=130)
    assert [line for line in lines if line.startswith("SET ASIDE:")] == [known.format("M-003")]
    open_bench(port).module.memory.boot_count += 1  # of another one with these settings
    batch(*ALLOWED, "--all-new", "--names", "N-001")


@pytest.mark.parametrize(
    ("at", "plugs"),
    [
        ("UNPLUG, NEXT", [new(2)]),
        ("PLUG IN: M-002 A module answers: leave it plugged in.", [new(2), new(3)]),
    ],
)
@pytest.mark.promise("i")
def test_a_name_that_another_program_gives_meanwhile_is_not_given_twice(
    batch: Batch, at: str, plugs: list[Plug]
) -> None:
    def give() -> None:
        with closing(open_store()) as store:
            store.write(partial(remember, name="M-002")).result()

    lines = batch(*ALLOWED, "--names", "M-001..M-003", plugs=plugs, at=at, act=give, code=1)
    told = [line.split()[:2] for line in lines if line.startswith("M-002 ")]
    assert told == [["M-002", "is"], ["M-002", "open"]]
    assert (_verdicts("M-001"), _verdicts("M-002"), _verdicts("M-003")) == (["READY"], [], ["READY"])


def pulled(bench: SimulatedBench) -> None:
    """The cable is in nobody's hands for a while; then another module is at its end."""
    bench.change(mute=True)
    bench.module.memory = Memory(boot_count=2)
    bench.module.plan(bench.clock() + 0.7, lambda _at_s: bench.change(mute=False))


def replugged(bench: SimulatedBench) -> None:
    bench.unplug()
    new(2)(bench)
    bench.plug()


@pytest.mark.parametrize("goes", [new(2), pulled, replugged])
def test_the_next_one_is_waited_for_until_the_one_that_was_named_has_gone(batch: Batch, goes: Plug) -> None:
    """It stays plugged in for some seconds, and would be the next one otherwise."""

    def slowly(bench: SimulatedBench) -> None:
        at_frame(bench, 30, lambda: goes(bench), is_lost=True)

    lines = batch(*ALLOWED, plugs=[slowly])
    assert [line for line in lines if line.startswith("SET ASIDE")] == []
    assert (_verdicts("M-001"), _verdicts("M-002")) == (["READY"], ["READY"])


def test_it_goes_on_where_it_was_interrupted(batch: Batch) -> None:
    lines = batch(*ALLOWED, plugs=[stop], code=130)
    assert [line.split()[:2] for line in lines[-2:]] == [["M-001", "READY"], ["M-002", "open"]]
    lines = batch(*ALLOWED, plugs=[new(2)])
    assert "PLUG IN: M-001" not in lines
    assert [line.split()[:2] for line in lines[-3:]] == [["M-001", "READY"], ["M-002", "READY"], ["SET", "ASIDE"]]
    assert batch(*ALLOWED)[2].startswith("M-002  READY")  # nothing is left, and nothing is waited for


@pytest.mark.parametrize("frame", some(range(2, 170, 4), one_in=4))
@pytest.mark.promise("i")
def test_a_module_that_is_exchanged_meanwhile_gets_no_name(batch: Batch, port: str, frame: int) -> None:
    """Another one with the same settings, from its restart on."""

    def exchange() -> None:
        open_bench(port).module.memory.attitude_threshold, open_bench(port).module.memory.freefall_time = 65, 140
        open_bench(port).restart()

    at_frame(open_bench(port), frame, exchange, is_lost=True)
    lines = batch(*ALLOWED, plugs=[stop], code=130)
    assert next(line for line in lines if line.startswith("SET ASIDE")) == "SET ASIDE: The module restarted."
    assert _verdicts("M-001") == []
    with closing(open_store()) as store:
        assert not store.read(modules)


def test_a_setting_that_the_module_refuses_sets_it_aside_and_is_named(batch: Batch, port: str) -> None:
    refuse(open_bench(port))
    lines = batch(*ALLOWED, plugs=[stop], code=130)
    assert any(line.startswith("SET ASIDE: Attitude threshold: ") for line in lines)


@pytest.mark.promise("i")
def test_a_full_disk_ends_the_batch_and_nothing_has_half_a_name(
    batch: Batch, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    add = Facts.add

    def full(self: Facts, content: Content, *args: Any, **values: Any) -> Row:
        if isinstance(content, ModuleProvisioned):
            raise StoreError("It cannot be used.")
        return add(self, content, *args, **values)

    def unopened(_path: Path) -> None:
        raise StoreError("It cannot be used.")

    with monkeypatch.context() as patch:
        patch.setattr("app.store.fact_store.open_file", unopened)
        assert "PLUG IN: M-001" not in batch(*ALLOWED, code=1)
    with monkeypatch.context() as patch:
        patch.setattr(Facts, "add", full)
        assert ["M-001", "open"] in [line.split() for line in batch(*ALLOWED, code=4)]
    assert _verdicts("M-001") == []
    assert batch(*ALLOWED, plugs=[new(2)])[-1].startswith("M-002  READY")


@pytest.mark.parametrize(
    ("words", "further"),
    [
        (ALLOWED[1:], ""),  # nothing without --yes
        (ALLOWED[:1], ""),  # the profile does not enable the triggers
        (ALLOWED, "freefall_trigger = false\n"),  # takes protection away
        (ALLOWED, "[tests]\ntilt = 180\n"),
        (ALLOWED, "[[manual]]\ntext = 'Bridle free'\nrequired = true\n"),
        ((*ALLOWED, "--labels", "missing/labels.pdf"), ""),
        ((*ALLOWED, "--names", "M-001..M-1\x1b[2J"), ""),
    ],
)
@pytest.mark.promise("i")
def test_without_consent_or_where_no_module_can_pass_nothing_is_sent(
    batch: Batch, wire: list[bytes], words: tuple[str, ...], further: str
) -> None:
    batch(*words, profile=SETTINGS + further, code=2)
    assert wire == []


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("M-008..M-011", ("M-008", "M-009", "M-010", "M-011")),
        ("9..10", ("9", "10")),
        ("伞仓", ("伞仓",)),
        *((wrong, None) for wrong in ("", " ", "M-2..M-1", "M-1..N-2", "M-1..", "..M-1", "a..b", "M-1..M-1001",
                                      "M-01..M-1",
                                      "M-1\n", "\u202eM-1", "M" * 61, "M-1..M-999999999999")),
    ],
)  # fmt: skip
def test_names_count_upwards(text: str, names: tuple[str, ...] | None) -> None:
    parse = BY_NAME["provision"].parse_words
    words = ["--profile", "p.toml", f"--names={text}"]
    if names is not None:
        assert parse(words).names == names
        return
    with pytest.raises(Refused):
        parse(words)
