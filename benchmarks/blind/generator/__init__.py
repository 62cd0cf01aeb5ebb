"""Sealed cases: rigs and hidden effects drawn at random and simulated in time."""
