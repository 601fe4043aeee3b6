"""Scenarios as files: schema, loader, variations, library."""
