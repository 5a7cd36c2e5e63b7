"""Tests of app/procedures/."""
