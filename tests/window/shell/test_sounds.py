"""Sounds: none until they are chosen, by the first player that works, and never waited for."""

import sys
import time
import wave
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.window.fake_ports import ports_alone
from ui.core.preferences import Preferences
from ui.shell.announcements import Sound, StateAnnouncer, write_tones


def player(folder: Path, name: str, *, code: int, seconds: int = 0) -> Path:
    """A program that notes what it is to play."""
    played = folder / f"{name}.txt"
    program = folder / name
    program.write_text(f'#!/bin/sh\necho "$@" >> {played}\n/bin/sleep {seconds}\nexit {code}\n', encoding="utf-8")
    program.chmod(0o755)
    return played


@pytest.mark.skipif(sys.platform == "win32", reason="the players are scripts")
def test_a_chosen_sound_is_played_by_the_first_player_that_works(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    beeps: list[bool] = []
    monkeypatch.setattr(QApplication, "beep", lambda: beeps.append(True))
    preferences, ports = Preferences(tmp_path / "window.ini"), ports_alone()
    sounds = StateAnnouncer(ports.ports, preferences)
    sounds.play(Sound.ACTIVE)
    preferences.has_sounds = True
    sounds.play(Sound.ACTIVE)
    qtbot.waitUntil(lambda: beeps == [True])  # no player; before it was chosen, nothing
    broken = player(tmp_path, "paplay", code=1)
    works = player(tmp_path, "aplay", code=0)
    sounds.play(Sound.TRIGGERED)
    qtbot.waitUntil(works.exists)
    assert broken.exists()
    option, path = works.read_text(encoding="utf-8").split()
    assert (option, Path(path).name) == ("-q", "triggered.wav")
    write_tones(tmp_path / "tones.wav", Sound.TRIGGERED.value)
    with wave.open(str(tmp_path / "tones.wav")) as file:
        assert 0.5 < file.getnframes() / file.getframerate() < 2
    player(tmp_path, "pw-play", code=0, seconds=2)
    began = time.monotonic()
    sounds.play(Sound.LOST_WHILE_ACTIVE)
    assert time.monotonic() - began < 1.5, "a player that hangs keeps nobody waiting"
    assert beeps == [True]
    ports.stop()
