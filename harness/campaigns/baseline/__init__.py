"""Regression: stored results against a committed baseline, by order, constant and verdict."""
