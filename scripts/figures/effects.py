"""Figures of docs/effects.md."""

FIGURES = {}
