"""What no cause of the catalogue explains, learnt as an extension of the model."""
