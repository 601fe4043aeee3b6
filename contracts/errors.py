"""Errors that a user can act on. Each message is one sentence naming the thing, the value and the way out."""


class GantryError(Exception):
    """Base of every error that Gantry raises on purpose."""


class InputError(GantryError, ValueError):
    """What the caller handed in cannot be used: a file, a key, an argument. Exit status 2 on the command line."""


class CalibrationError(GantryError):
    """The images or points are well-formed but do not determine a camera."""
