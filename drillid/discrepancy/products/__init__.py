"""What follows from a verdict: extended models, predictions, immittances, advice, the dataset."""
