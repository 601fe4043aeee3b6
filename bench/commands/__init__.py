"""Commands that have modules of their own; ``bench.cli`` registers them."""
