"""Tests of ui/pages/logs/."""
