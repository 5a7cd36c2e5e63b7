"""Tests of what is installed: packages, their scripts, Windows, the desktop's screen reader."""
