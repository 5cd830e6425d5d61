"""Drawings of lines, SVG and DXF: strokes with a role each, healed, as a sheet of creases or a layer's shape."""
