"""Simulators, their runs and results."""
