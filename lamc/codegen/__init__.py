"""From a program to C text, and from C text to a compiled module in the cache. It knows no physics."""
