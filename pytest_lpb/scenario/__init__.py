"""Scenario files: reading YAML, the schema, loading, and drawing concrete problems."""
