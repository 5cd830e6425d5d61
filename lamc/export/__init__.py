"""`lamc export`: a mechanism in its scene as files for other programs."""
