"""Plate files and field files."""
