"""Systems of equations of a problem: assembly, constraints, load vectors, factorisation, refinement."""
