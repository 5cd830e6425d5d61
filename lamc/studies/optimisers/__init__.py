"""Ways to look for the least cost of a problem; each ends where it sees no better, or where runs are spent."""
