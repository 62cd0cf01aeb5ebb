"""The eight parameters of the paper's model: names, order, units, bounds and scales."""

import numpy as np

PARAMETERS = {
    "kappa": ("N s m-4", "external viscous damping of mud and wall"),
    "delta": ("N s m-2", "internal damping of the steel"),
    "length": ("m", "length of the drill pipe"),
    "polar_moment": ("m4", "polar moment of the drill pipe"),
    "delay": ("s", "delay of the drive"),
    "inertia_td": ("kg m2", "inertia of the top drive"),
    "damping_bha": ("N m s rad-1", "viscous damping of the bottom-hole assembly"),
    "inertia_bha": ("kg m2", "inertia of the bottom-hole assembly, collars included"),
}
"""The eight parameters of the paper's model: CF unit and meaning, in the order used everywhere."""

BOUNDS = np.array(
    [
        [0.0, 1e5, 200.0, 5e-7, 0.0, 50.0, 0.0, 0.1],
        [2e4, 1e11, 1e4, 2e-4, 0.3, 2e4, 2e4, 3e3],
    ]
)
"""Least and largest value of each parameter, SI: wider than for any rig."""
SCALES = np.array([100.0, 3e8, 1000.0, 1e-5, 0.01, 1000.0, 50.0, 50.0])
"""Typical magnitude of each parameter, SI."""
USUAL = np.array(
    [
        [0.0, 3e7, 300.0, 6e-7, 0.0, 200.0, 0.0, 20.0],
        [1e3, 3e9, 9000.0, 5e-5, 0.15, 6000.0, 1e3, 1e3],
    ]
)
"""Range of each parameter over existing rigs, SI; a prior no narrower than this is uninformative."""
KAPPA, DELTA, LENGTH, POLAR_MOMENT, DELAY, INERTIA_TD, DAMPING_BHA, INERTIA_BHA = range(len(PARAMETERS))
