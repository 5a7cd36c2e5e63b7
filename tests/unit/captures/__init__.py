"""Tests of app/captures/."""
