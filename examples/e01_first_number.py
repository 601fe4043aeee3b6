"""Run one vehicle past the cameras and print how far from the truth it was located."""

import tempfile
from pathlib import Path

from bench.jobs import run_scenario
from bench.scores import by_name
from bench.wiring import Stages
from scenarios.loader import load_scenario

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as directory:
        outcome = run_scenario(load_scenario("oval-one-vehicle"), Stages(), Path(directory) / "run")
    error = by_name(outcome.scores)["ground.rms_x_m"]
    print(f"RMS error along x over {error.n} positions: {1000 * (error.value or 0):.2f} mm")
