"""Tests of app/recordings/."""
