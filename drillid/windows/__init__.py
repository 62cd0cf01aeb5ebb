"""Records → state of the rig, segments, and windows of steady drilling with the sweep on."""
