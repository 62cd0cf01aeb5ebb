"""Detections in a window's own record of causes that its linear response does not show."""
