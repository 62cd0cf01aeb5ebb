"""A nonlinear rig in the time domain, independent of the frequency-domain models that are fitted."""
