"""Stages that others wrote, found by path (``my_pkg.mod:Mine``) or by the short name of an entry point."""

import difflib
import importlib
import importlib.metadata
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from contracts import Analyst, Detector, Fuser, GantryError, InputError, Locator, Perceiver, Tracker

GROUPS: dict[type, str] = {
    Detector: "gantry.detectors",
    Tracker: "gantry.trackers",
    Perceiver: "gantry.perceivers",
    Locator: "gantry.locators",
    Fuser: "gantry.fusers",
    Analyst: "gantry.analysts",
}
"""Entry-point group in which packages announce implementations of each protocol."""


def load_object(name: str, protocol: type) -> Any:
    """A fresh stage, made without arguments by what ``name`` stands for: see ``load_factory``.

    Raises InputError if it cannot be found or made, or lacks a method of ``protocol``.
    """
    factory = load_factory(name, protocol)
    try:
        stage = factory()
    except GantryError:
        raise
    except Exception as error:  # the author's code may fail in any way; say where, keep the cause
        raise InputError(f"{name} cannot be made without arguments: {type(error).__name__}: {error}") from error
    require_methods(stage, protocol, name=name)
    return stage


def load_factory(name: str, protocol: type) -> Callable[..., Any]:
    """The class or function that ``name`` stands for: ``package.module:Name`` or an entry point's short name.

    protocol: what it makes; a class that lacks one of its methods is refused at once.
    Raises InputError saying what is missing.
    """
    target = _from_path(name) if ":" in name else _from_entry_point(name, protocol)
    if not callable(target):
        raise InputError(f"{name} is a {type(target).__name__}, not a class or function that could be called")
    if inspect.isclass(target):
        require_methods(target, protocol, name=name)
    factory: Callable[..., Any] = target
    return factory


def require_methods(thing: object, protocol: type, *, name: str) -> None:
    """Raise InputError naming the methods of ``protocol`` that ``thing`` (``name`` in the message) lacks."""
    wanted = [method for method, value in vars(protocol).items() if inspect.isfunction(value) and method[0] != "_"]
    missing = [method for method in wanted if not callable(getattr(thing, method, None))]
    if missing:
        raise InputError(f"{name} is no {protocol.__name__}: it lacks {' and '.join(f'{one}()' for one in missing)}")


def short_names(protocol: type) -> tuple[str, ...]:
    """The short names that installed packages offer for ``protocol``."""
    return tuple(sorted(importlib.metadata.entry_points(group=GROUPS[protocol]).names))


def _from_path(name: str) -> Any:
    module_name, _, attributes = name.partition(":")
    if not module_name or module_name.startswith("."):
        raise InputError(f"{name!r} names no module; give a path such as my_pkg.mod:Mine")
    module = _import(name, module_name)
    target: Any = module
    for attribute in attributes.split("."):
        if not hasattr(target, attribute):
            raise InputError(f"{name}: {target.__name__} has no {attribute!r}{_near(target, attribute)}")
        target = getattr(target, attribute)
    return target


def _import(name: str, module_name: str) -> Any:
    if str(Path.cwd()) not in sys.path:
        sys.path.append(str(Path.cwd()))  # the installed command, unlike `python -m`, does not look there by itself
    try:
        return importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name and (module_name == error.name or module_name.startswith(f"{error.name}.")):
            raise InputError(f"{name}: there is no module {error.name!r} on the path") from error
        raise InputError(f"{name}: {module_name} needs the module {error.name!r}, which is not installed") from error
    except Exception as error:  # the author's module may fail in any way; say where, keep the cause
        raise InputError(f"{name}: importing {module_name} fails: {type(error).__name__}: {error}") from error


def _near(target: object, attribute: str) -> str:
    near = difflib.get_close_matches(attribute, dir(target), n=1)
    return f"; did you mean {near[0]!r}?" if near else ""


def _from_entry_point(name: str, protocol: type) -> Any:
    found = list(importlib.metadata.entry_points(group=GROUPS[protocol], name=name))
    if not found:
        offered = short_names(protocol)
        raise InputError(
            f"nothing is called {name!r}; give a path such as my_pkg.mod:Mine"
            + (f" or one of: {', '.join(offered)}" if offered else "")
        )
    return _from_path(f"{found[0].module}:{found[0].attr}")
