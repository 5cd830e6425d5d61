"""Bodies and hinges of a laminate design as plates."""
