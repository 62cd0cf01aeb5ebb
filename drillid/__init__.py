"""Identification while drilling: torsional dynamics of the drilling system from rig logs."""

__version__ = "0.1.0"
