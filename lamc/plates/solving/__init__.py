"""From a problem to its solution: constraints, load vectors, sparse systems, refinement."""
