"""What an ideal test that knows the hidden effect would see."""
