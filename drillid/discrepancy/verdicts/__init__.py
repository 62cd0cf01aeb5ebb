"""From evidence to verdicts: the engine, names, probabilities, intervals of depth."""
