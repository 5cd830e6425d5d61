"""Meshes: grids, triangles for any polygon, files, and what a mesh means for an element."""
