"""What every floor stands on: errors and their places, checks of values, units, files, shipped data."""
