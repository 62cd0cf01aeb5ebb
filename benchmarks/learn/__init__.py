"""What one well cannot tell: evidence over fleets, and what is learnt where no cause explains."""
