"""Tests of app/limits/."""
