"""The spanning tree of a mechanism, and the frames of its hinges."""
