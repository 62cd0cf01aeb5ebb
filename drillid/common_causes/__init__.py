"""Causes that wells have in common: evidence over wells that share a rig, a hole section or a tool."""
