"""Figures of docs/batch.md."""

FIGURES = {}
