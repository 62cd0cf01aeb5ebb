"""A second world: another simulator than the library's, on rigs with what real ones have, and nothing of the engine."""
