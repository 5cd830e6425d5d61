"""Bodies, joints, their file formats, and the spanning tree."""
