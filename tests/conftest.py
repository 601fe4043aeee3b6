"""How Hypothesis runs here: no deadline, since a busy machine is not a fault, and few examples of each law."""

from hypothesis import settings

settings.register_profile("gantry", deadline=None, max_examples=30)
settings.load_profile("gantry")
