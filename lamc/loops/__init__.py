"""Closed loops in numbers: rank, misfit, starts that close, branches. In: a `Tree`. Never: sympy or compiled code."""
