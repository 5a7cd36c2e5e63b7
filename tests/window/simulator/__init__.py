"""Tests of ui/simulator/."""
