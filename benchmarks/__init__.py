"""Measurements of speed and agreement, run on demand: ``python -m benchmarks.NAME [--json]``."""
