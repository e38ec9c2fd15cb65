"""Figures of docs/numerics.md."""

FIGURES = {}
