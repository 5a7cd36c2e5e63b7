"""Tones: each is sound that differs from the others, and nothing is left behind."""

import sys
import wave
from io import BytesIO
from pathlib import Path

import pytest

from app.system.tones import RATE_HZ, Tone, TonePlayer, wav


def test_each_tone_is_a_short_sound_of_its_own() -> None:
    sounds = set()
    for tone in Tone:
        with wave.open(BytesIO(wav(tone))) as file:
            seconds = file.getnframes() / file.getframerate()
            samples = memoryview(file.readframes(file.getnframes())).cast("h")
            assert (file.getnchannels(), file.getframerate()) == (1, RATE_HZ)
        assert seconds == pytest.approx(sum(note[1] for note in tone.value), abs=0.01)
        assert seconds < 1
        assert 10_000 < max(samples) < 20_000
        assert (samples[0], samples[-1]) == (0, 0)  # no click
        sounds.add(bytes(samples))
    assert len(sounds) == len(Tone)


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script stands for the player")
def test_it_is_played_by_the_system_and_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    heard = tmp_path / "heard"
    player = tmp_path / "paplay"
    player.write_text(f'#!/bin/sh\ncp "$1" "{heard}.part" && mv "{heard}.part" "{heard}"\n', encoding="utf-8")
    player.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    monkeypatch.setattr("app.system.tones._PLAYERS", ("paplay",))
    monkeypatch.setattr("app.system.tones.sys.platform", "linux")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    tones = TonePlayer()
    assert tones.play(Tone.TRIGGERED)
    for one in tones._running:
        assert one.wait(30) == 0
    assert heard.read_bytes() == wav(Tone.TRIGGERED)
    tones.close()
    assert not list(tmp_path.glob("dps-s-tones-*"))


def test_without_a_player_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.system.tones._PLAYERS", ())
    monkeypatch.setattr("app.system.tones.sys.platform", "linux")
    tones = TonePlayer()
    assert not tones.play(Tone.LOST)
    tones.close()
