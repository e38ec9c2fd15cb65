"""Figures of docs/performance.md."""

FIGURES = {}
