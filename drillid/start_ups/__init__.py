"""Measured starts of rotation: a described well is fitted to the first part of the log and judged on the rest."""
