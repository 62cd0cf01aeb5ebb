"""The ideal test, which knows the hidden effect: its power, and the causes that it cannot distinguish."""
