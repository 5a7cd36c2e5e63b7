"""Tests of app/fleet/."""
