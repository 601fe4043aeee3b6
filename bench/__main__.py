"""``python -m bench`` is ``gantry``."""

from bench.cli import main

main()
