"""The torsional dynamics of top drive, drill string and bottom-hole assembly, in the Laplace variable s."""
