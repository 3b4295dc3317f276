"""YAML documents: read with the place of every value, written so that any YAML reader gets the same data back."""
