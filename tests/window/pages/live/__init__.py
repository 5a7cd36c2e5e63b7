"""Tests of ui/pages/live/."""
