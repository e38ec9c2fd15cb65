"""Figures of docs/accuracy.md."""

FIGURES = {}
