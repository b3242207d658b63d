"""Figures of the theory: one function a figure, a file a chapter."""
