"""Tests of ui/plots/."""
