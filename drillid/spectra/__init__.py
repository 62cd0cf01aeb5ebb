"""Windows → cross spectra of sweep, torque and speed with their noise, and spectrograms."""
