"""Many C files as one: C text as tokens, tokens as declarations, and of these the ones that are needed."""
