"""Studies: a design run again and again with other numbers, and what is measured of each run."""
