"""Runs a scenario through the chain, records it, scores it, reports it."""
