"""The joint model of a set of windows, its fit, and the search over causes."""
