"""All windows of a well fitted together: shared equipment, with damping and assembly varying with depth."""
