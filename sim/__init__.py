"""The simulated world and its exact truth: motion, scene, film, lens and sensor."""

import os

os.environ.setdefault("MUJOCO_GL", "egl")  # MuJoCo reads it when it is imported: draw off-screen, without a display
