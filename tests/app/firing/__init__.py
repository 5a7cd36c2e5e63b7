"""Tests of app/firing/."""
