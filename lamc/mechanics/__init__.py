"""The symbolic core: staged expressions, frames and vectors, Kane's equations."""
