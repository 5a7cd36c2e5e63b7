"""Tests of app/settings/."""
