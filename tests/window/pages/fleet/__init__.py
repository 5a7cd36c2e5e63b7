"""Tests of ui/pages/fleet/."""
