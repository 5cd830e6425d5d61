"""Staged symbolic arithmetic: the store, functions, expressions and their domains, programs."""
