"""Tests of ui/pages/commands/."""
