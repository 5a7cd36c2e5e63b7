"""The entry, its commands, and the lock that they install."""

import ast
import os
import re
import sys
import tomllib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import NormalizedName, canonicalize_name

from tests.support.setup_files import PACKAGING, ROOT, SetupFiles


def test_old_pythons_can_read_the_entry_and_are_refused(setup: SetupFiles) -> None:
    source = (PACKAGING / "bootstrap.py").read_bytes()
    assert source.isascii()
    tree = ast.parse(source, feature_version=(3, 4))
    too_new = (ast.JoinedStr, ast.AnnAssign, ast.NamedExpr, ast.Match, ast.AsyncFunctionDef, ast.Nonlocal)
    assert not [node for node in ast.walk(tree) if isinstance(node, too_new)]
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            assert node.returns is None
            assert not node.args.kwonlyargs
            assert not any(argument.annotation for argument in node.args.args)
    refusal = setup.bootstrap.refusal
    for version in ((2, 7), (3, 6, 15), (3, 10, 99)):
        assert refusal(version).startswith(
            f"DPS-S Configurator needs Python 3.11 or later, and this is Python {version[0]}.{version[1]}: "
        )
    for version in ((3, 11), (3, 12, 1), (4, 0)):
        assert refusal(version) is None


def test_all_after_the_check_waits_for_it() -> None:
    """The entry imports nothing of ours before it has looked at the version."""
    tree = ast.parse((PACKAGING / "bootstrap.py").read_text(encoding="utf-8"))
    at_top = [alias.name for node in tree.body if isinstance(node, ast.Import) for alias in node.names]
    assert at_top == ["sys"]
    assert not [node for node in tree.body if isinstance(node, ast.ImportFrom)]


@pytest.mark.parametrize(
    "name",
    [
        "packaging/bootstrap.py",
        "packaging/commands.py",
        "packaging/environment.py",
        "packaging/system_libraries.py",
        "app/__init__.py",
        "app/system/__init__.py",
        "app/system/qt_libraries.py",
        "app/system/screen.py",
        "app/text/__init__.py",
        "app/text/i18n.py",
        "app/text/sentences.py",
    ],
)
def test_the_standard_library_is_enough(name: str) -> None:
    from tests.test_layers import imports

    source = (PACKAGING.parent / name).read_text(encoding="utf-8")
    modules = {one.module.removesuffix(f".{one.module.rpartition('.')[2]}") for one in imports(source)}
    ours = {"bootstrap", "commands", "environment", "system_libraries", "app.system.qt_libraries"}
    ours |= {"app.system.screen", "app.text.i18n", "app.text.sentences"}
    assert {module for module in modules if module.partition(".")[0] not in sys.stdlib_module_names} <= ours


def pretend_all_is_ready(setup: SetupFiles, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(setup.environment, "make_ready", lambda extent: None)
    patch.setattr(setup.environment, "is_current", lambda extent: True)
    patch.setattr(setup.system_libraries, "make_ready", lambda **_: None)


@pytest.fixture
def ready(setup: SetupFiles, monkeypatch: pytest.MonkeyPatch) -> list[tuple[list[str], dict[str, str]]]:
    """Everything is installed, and programs are recorded."""
    calls: list[tuple[list[str], dict[str, str]]] = []

    def call(program: list[Any], **variables: str) -> int:
        calls.append(([str(word) for word in program], variables))
        return 7

    pretend_all_is_ready(setup, monkeypatch)
    monkeypatch.setattr(setup.commands, "call", call)
    return calls


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["test", "-k", "foo"], ["-m", "pytest", "-n", "4", "--dist", "worksteal", "-k", "foo"]),
        (["bench", "--quick"], ["-m", "tests.benchmarks", "--quick"]),
        (["soak"], ["-m", "tests.soak"]),
        (["run", "read", "--port", "sim://"], ["read", "--port", "sim://"]),
        (["translations", "check"], ["docs/generate/translations.py", "check"]),
    ],
)
def test_arguments_are_passed_on(
    setup: SetupFiles, ready: list[Any], arguments: list[str], words: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(setup.commands.os, "cpu_count", lambda: 2)
    assert setup.commands.main(arguments) == 7
    assert [program[1:] for program, _ in ready] == [words]


def test_each_campaign_of_the_night_runs_though_one_before_it_failed(
    setup: SetupFiles, ready: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HYPOTHESIS_PROFILE", "quick")
    assert setup.commands.main(["nightly"]) == 7
    campaigns = [program[2] for program, _ in ready]
    assert campaigns == [
        "pytest",
        "tests.soak",
        *["tests.gestures"] * 2,
        "tests.adversary",
        "tests.benchmarks",
    ]
    assert os.environ["HYPOTHESIS_PROFILE"] == "thorough"


@pytest.mark.parametrize("command", ["demo", "test", "windows", "package", "run"])
def test_help_of_a_command_installs_nothing(
    command: str, setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(setup.environment, "is_current", lambda extent: False)
    for module in (setup.environment, setup.system_libraries):
        monkeypatch.setattr(module, "make_ready", lambda *_, **__: pytest.fail("something would be installed"))
    assert setup.commands.main([command, "--help"]) == 0
    assert capsys.readouterr().out == f"bootstrap.py {command}: {setup.commands.COMMANDS[command].explanation}\n"


def test_yes_stands_before_the_command_and_goes_to_what_installs(
    setup: SetupFiles, ready: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(setup.environment.YES, "")
    assert setup.commands.main(["--yes", "run", "set", "--yes"]) == 7
    assert ready[0][0][1:] == ["set", "--yes"]
    assert os.environ[setup.environment.YES] == "1"


def test_tests_need_no_screen(setup: SetupFiles, ready: list[Any]) -> None:
    setup.commands.main(["test"])
    assert ready[0][1] == {"QT_QPA_PLATFORM": "offscreen"}


def test_check_runs_all_even_after_a_failure(setup: SetupFiles, ready: list[Any]) -> None:
    assert setup.commands.main(["check"]) == 7
    assert [program[2] for program, _ in ready] == ["ruff", "ruff", "mypy"]


def test_demo_opens_the_window(setup: SetupFiles, ready: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("QT_QPA_PLATFORM", raising=False)
    monkeypatch.setattr(setup.commands, "window_obstacle", lambda: None)
    assert setup.commands.main(["demo", "--lang", "zh_CN"]) == 7
    assert ready[0][0][1:] == ["gui", "--demo", "--lang", "zh_CN"]


@pytest.mark.parametrize(
    ("platform", "why"), [("", "No screen."), ("offscreen", "QT_QPA_PLATFORM asks for no screen (offscreen).")]
)
def test_demo_without_a_screen_says_so_and_where_the_evidence_is(
    setup: SetupFiles,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    platform: str,
    why: str,
) -> None:
    evidence = tmp_path / "demo"
    calls: list[list[str]] = []

    def call(program: list[Any], **variables: str) -> int:
        calls.append([str(word) for word in program[1:]])
        evidence.mkdir()
        (evidence / "values.json").touch()
        return 0

    pretend_all_is_ready(setup, monkeypatch)
    monkeypatch.setenv("QT_QPA_PLATFORM", platform)
    monkeypatch.setattr(setup.commands, "window_obstacle", lambda: None if platform else why)
    monkeypatch.setattr(setup.commands, "call", call)
    monkeypatch.setattr(setup.commands, "EVIDENCE", evidence)
    assert setup.commands.main(["demo"]) == 0
    assert calls == [["gui", "--demo", "--offscreen-seconds", "10", "--evidence", str(evidence)]]
    printed = capsys.readouterr().out
    assert printed.startswith(why)
    assert str(evidence / "values.json") in printed


def test_a_missing_requirement_is_reported_in_one_sentence_with_code_3(
    setup: SetupFiles, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(extent: str) -> None:
        raise setup.environment.SetupError("Type: sudo apt-get install libegl1")

    pretend_all_is_ready(setup, monkeypatch)
    monkeypatch.setattr(setup.environment, "make_ready", refuse)
    assert setup.commands.main(["test"]) == 3
    assert capsys.readouterr().err == "Type: sudo apt-get install libegl1\n"


@pytest.mark.parametrize("arguments", [[], ["dance"]])
def test_an_unknown_command_is_code_2(setup: SetupFiles, arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        setup.commands.main(arguments)
    assert caught.value.code == 2


def test_programs_end_with_their_own_code(setup: SetupFiles, capfd: pytest.CaptureFixture[str]) -> None:
    call = setup.commands.call
    assert call([sys.executable, "-c", "raise SystemExit(5)"]) == 5
    script = "import os; print(os.environ['DPS_S_A'], os.environ['DPS_S_B'])"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DPS_S_A", "the user's")
        assert call([sys.executable, "-c", script], DPS_S_A="ours", DPS_S_B="ours") == 0
    assert capfd.readouterr().out.strip() == "the user's ours"


def test_the_lock_is_exact_and_fits_the_project() -> None:
    lines = (PACKAGING / "lock.txt").read_text(encoding="utf-8").splitlines()
    locked = [Requirement(line) for line in lines if line and not line.startswith("#")]
    assert all(requirement.url is None and "--" not in str(requirement) for requirement in locked)
    assert all([one.operator for one in requirement.specifier] == ["=="] for requirement in locked)
    names = [canonicalize_name(one.name) for one in locked]
    for system in SYSTEMS:
        fitting = [one for one in locked if one.marker is None or one.marker.evaluate(system)]
        versions = {canonicalize_name(one.name): next(iter(one.specifier)).version for one in fitting}
        assert len(versions) == len(fitting), system
        assert set(names) - {name for name, count in Counter(names).items() if count == 1} <= set(versions)
        _check_versions(versions)


def test_what_the_program_and_its_installation_need_is_locked_apart(setup: SetupFiles) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wanted = {canonicalize_name(Requirement(one).name) for one in project["project"]["dependencies"]}
    wanted |= {canonicalize_name(Requirement(one).name) for one in project["build-system"]["requires"]}
    environment = setup.environment
    found = [canonicalize_name(Requirement(one).name) for one in environment.locked(environment.PROGRAM)]
    assert wanted <= set(found)
    assert not {"pytest", "mypy", "ruff", "pyinstaller"} & set(found)
    assert set(found) < {canonicalize_name(Requirement(one).name) for one in environment.locked(environment.EVERYTHING)}


SYSTEMS = [
    {"sys_platform": system, "python_version": version, "python_full_version": f"{version}.0"}
    for system in ("linux", "win32", "darwin")
    for version in ("3.11", "3.13", "3.14")
]


def _check_versions(versions: Mapping[NormalizedName, str]) -> None:

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wanted = [*project["project"]["dependencies"], *project["project"]["optional-dependencies"]["dev"]]
    wanted += project["project"]["optional-dependencies"]["package"]
    wanted += project["build-system"]["requires"]
    for requirement in map(Requirement, wanted):
        assert requirement.specifier.contains(versions[canonicalize_name(requirement.name)]), requirement


def test_the_version_is_the_projects() -> None:
    import app

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert app.version() == project["version"]


def test_makefile_and_ci_use_commands_that_there_are(setup: SetupFiles) -> None:
    known = {*setup.commands.COMMANDS}
    rule = next(
        line for line in (ROOT / "Makefile").read_text(encoding="utf-8").splitlines() if line.startswith("demo")
    )
    assert set(rule.rstrip(":").split()) <= known
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    used = set(re.findall(r"bootstrap\.py (\w+)", script))
    assert {"test", "check", "demo"} <= used <= known
