"""Laminates: materials, plies, stiffness, and when plies fail."""
