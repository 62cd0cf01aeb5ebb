"""All windows of a well fitted together: shared equipment, damping and assembly that vary with depth."""
