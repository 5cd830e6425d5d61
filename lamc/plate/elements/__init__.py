"""Finite elements, derived by sympy from their shape functions."""
