"""Plates: laminates, finite elements, meshes, problems and their answers. Users take them from `lamc.plate`."""
