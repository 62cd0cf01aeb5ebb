"""Spectra → command mobility with its variance and coherence gate, and stacks of windows."""
