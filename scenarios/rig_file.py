"""Camera rigs by name or by file."""

from pathlib import Path

from contracts import InputError
from scenarios.toml_file import read_toml
from sim.rig import RigSpec

RIGS = Path(__file__).parent / "rigs"


def rig_names() -> tuple[str, ...]:
    """Names of the rigs that come with Gantry."""
    return tuple(sorted(path.stem for path in RIGS.glob("*.toml")))


def load_rig(name_or_path: str | Path) -> RigSpec:
    """The rig of that name, or in that TOML file; InputError naming file and fault.

    A text that ends in ``.toml`` is a path.
    """
    path = Path(name_or_path)
    if path.suffix != ".toml":
        if str(name_or_path) not in rig_names():
            raise InputError(
                f"rig {str(name_or_path)!r} is unknown; there are {', '.join(rig_names())}, or a .toml file"
            )
        path = RIGS / f"{name_or_path}.toml"
    return read_toml(path, RigSpec)
