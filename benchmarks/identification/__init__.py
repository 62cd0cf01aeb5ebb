"""Accuracy, bounds and speed of identification, beside other tools."""
