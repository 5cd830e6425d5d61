"""Numbers of a model from what was measured on the device."""
