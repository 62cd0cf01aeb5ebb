"""Excitation torques and their design."""
