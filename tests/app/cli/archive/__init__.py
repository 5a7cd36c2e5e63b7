"""Tests of app/cli/archive/."""
