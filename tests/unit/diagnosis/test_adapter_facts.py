"""Facts of the system about an adapter, the history of adapters, and the udev rule."""

import os
import re
from pathlib import Path

import pytest

from app.diagnosis.adapter_facts import AdapterFacts, facts_about

# What the system tells


def tree(root: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return root


@pytest.fixture
def linux(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.diagnosis.adapter_facts.sys.platform", "linux")


@pytest.mark.usefixtures("linux")
def test_programs_that_grab_ports_are_found(tmp_path: Path) -> None:
    root = tree(tmp_path, {
        "proc/12/comm": "ModemManager\n",
        "proc/13/comm": "brltty\n",
        "proc/14/comm": "bash\n",
        "dev/ttyUSB0": "",
    })  # fmt: skip
    facts = facts_about("/dev/ttyUSB0", root=root)
    assert facts.grabbers == ("ModemManager", "brltty")


@pytest.mark.usefixtures("linux")
def test_missing_files_give_no_facts(tmp_path: Path) -> None:
    facts = facts_about("/dev/ttyUSB0", root=tmp_path)
    assert facts.group == "dialout"
    assert facts.grabbers == ()


def test_a_url_has_no_facts() -> None:
    assert facts_about("socket://10.0.0.2:4000") == AdapterFacts()


@pytest.mark.usefixtures("linux")
@pytest.mark.skipif(not hasattr(os, "getuid"), reason="groups are POSIX")
def test_the_group_of_a_device_file(tmp_path: Path) -> None:
    device = tree(tmp_path, {"dev/tty": ""}) / "dev" / "tty"
    device.chmod(0o600)
    assert facts_about("/dev/tty", root=tmp_path).group is None
    device.chmod(0o660)
    try:
        os.chown(device, -1, 20)
    except OSError:
        return
    assert facts_about("/dev/tty", root=tmp_path).group == device.group()


# The rule for the system


RULES = Path(__file__).parents[3] / "packaging" / "linux" / "60-dps-s.rules"
_ASSIGNMENT = re.compile(r'[A-Z]+(?:\{[A-Za-z_]+\})?(?:==|!=|\+=|=)"[^"]*"')


def rule_lines() -> list[str]:
    lines = RULES.read_text(encoding="ascii").splitlines()
    return [line for line in lines if line.strip() and not line.startswith("#")]


def test_each_line_of_the_rule_is_a_list_of_keys_and_values() -> None:
    for line in rule_lines():
        parts = [part.strip() for part in re.split(r",\s*(?=[A-Z])", line)]
        assert all(_ASSIGNMENT.fullmatch(part) for part in parts), line


def test_the_rule_covers_the_usual_adapters_and_excludes_modem_manager() -> None:
    adapters = [line for line in rule_lines() if "idVendor" in line and "uaccess" in line]
    vendors = {vendor for line in adapters for vendor in re.findall(r'idVendor\}=="([^"]+)"', line)[0].split("|")}
    assert {"0403", "10c4", "1a86", "067b", "1209", "2dae"} <= vendors
    for line in adapters:
        assert 'ENV{ID_MM_DEVICE_IGNORE}="1"' in line
    products = "|".join(re.findall(r'idProduct\}=="([^"]+)"', "\n".join(adapters))).split("|")
    assert {"6001", "ea60", "7523", "5523", "55d4", "2303", "5740"} <= set(products)
    assert all(re.fullmatch(r"[0-9a-f]{4}", product) for product in (*products, *vendors))


def test_the_rule_precedes_uaccess_and_every_goto_has_a_label() -> None:
    assert RULES.name < "73-seat-late.rules"
    text = RULES.read_text(encoding="ascii")
    assert set(re.findall(r'GOTO="(\w+)"', text)) == set(re.findall(r'LABEL="(\w+)"', text))
    assert "brltty" in text
