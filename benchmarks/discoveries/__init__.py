"""What the simulations get wrong on the wells, the motor bench and the field start of rotation."""
