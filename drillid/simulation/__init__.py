"""A non-linear rig in the time domain, apart from the frequency-domain models that are fitted."""
