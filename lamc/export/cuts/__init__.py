"""What leaves lamc for a cutter: lines of each layer in real size, as SVG and DXF."""
