"""Everything identified in a well against depth, and the fleet's table of it."""
