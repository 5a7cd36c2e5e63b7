"""Chinese on the command line has full-width punctuation throughout."""

import re

import pytest

import app.__main__ as program
from app.cli.commands import ENTRIES
from app.text.i18n import read_translations
from tests.documents.test_translations import GENERATE

pytest_plugins = ["tests.support.cli_fixtures"]

_HAN = r"[一-鿿]"
HALF_WIDTH = re.compile(
    rf"{_HAN}[,;:!?]|{_HAN} ?\(|\({_HAN}|{_HAN}\)|[,;!?]{_HAN}|[。，；：！？、] (?=[^\s→])|{_HAN}\.(?:\s|$)",
    re.MULTILINE,
)
"""A half-width mark beside a Chinese character, or a space behind a full-width one; two spaces part columns."""


def half_width(text: str) -> list[str]:
    return [text[max(0, found.start() - 12) : found.end() + 12] for found in HALF_WIDTH.finditer(text)]


@pytest.mark.parametrize(
    "text", ["选项:", "没有串口。 请插入", "串口 (dps-s ports)", "倾角, 光线", "已完成.", "倾角(度)", "真的吗?"]
)
def test_a_half_width_mark_is_found(text: str) -> None:
    assert half_width(text)


@pytest.mark.parametrize("text", ["选项：", "没有串口。请插入", "（dps-s ports）。", "3.80 V，见 x", "标题。  下一列"])
def test_a_full_width_one_is_left_alone(text: str) -> None:
    assert half_width(text) == []


def test_no_translation_has_one() -> None:
    texts = read_translations(GENERATE.parents[1] / "app" / "locale" / "zh_CN.ts")
    places = {chinese: re.sub(r" \(\*[^)]*\)|\(&[A-Z]\)|主机:端口", "", chinese) for chinese in texts.values()}
    assert {chinese: half_width(text) for chinese, text in places.items() if half_width(text)} == {}


@pytest.mark.parametrize(
    "words", [(), *((entry.name,) for entry in ENTRIES)], ids=lambda words: " ".join(words) or "all"
)
def test_no_help_has_one(
    words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("LC_ALL", "zh_CN.UTF-8")
    monkeypatch.setenv("COLUMNS", "500")
    assert program.main([*words, "--help"]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"用法：{' '.join(('dps-s', *words))}")
    assert "选项：" in said
    assert half_width(re.sub(r"主机:端口", "", said)) == []


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["read", "--port", "PORT?cell=3.5"], 0),
        (["read", "--port", "PORT?mute_codes=34"], 4),
        (["history", "--port", "PORT?history=3"], 0),
        (["find", "--port", "PORT", "-v"], 0),
        (["set", "freefall_acceleration_g=0.9", "--port", "PORT"], 2),
        (["set", "freefall_acceleration_g=0.9", "--accept-risk", "--port", "PORT"], 0),
        (["set", "tilt=3", "x", "--port", "PORT"], 2),
        (["set", "freefall_time_s=1.2", "--port", "PORT?active=yes"], 1),
        (["lock", "--port", "PORT"], 2),
        (["preflight", "--port", "PORT"], 1),
        (["decode", "41", "75", "32", "07", "0A", "00", "01", "45"], 4),
        (["decode", "zz"], 2),
        (["read", "--port", "/dev/no-such-port"], 3),
        (["read", "--port", "PORT", "--baud", "3"], 2),
        (["recordings", "delete", "none"], 2),
        (["verify"], 2),
        (["bogus"], 2),
    ],
    ids=lambda value: " ".join(value[:3]) if isinstance(value, list) else str(value),
)
@pytest.mark.usefixtures("user_files", "hasty")
def test_no_output_has_one(
    words: list[str], code: int, port: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("LC_ALL", "zh_CN.UTF-8")
    assert program.main([word.replace("PORT", port) for word in words]) == code
    printed = capsys.readouterr()
    assert re.search(_HAN, printed.out + printed.err)
    assert half_width(printed.out + printed.err) == []
