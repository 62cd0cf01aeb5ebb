"""Torques to excite a rig with, and their design."""
