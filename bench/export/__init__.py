"""Recorded runs in formats that other tools read."""

from pathlib import Path

from bench.export.coco import export_coco
from bench.export.geojson import export_geojson
from bench.export.images import export_images
from bench.export.mot import export_mot
from contracts import InputError

EXPORTS = {"mot": export_mot, "coco": export_coco, "geojson": export_geojson, "images": export_images}
"""By format: a function that writes the run in one directory to another and returns what it wrote."""


def export_run(directory: Path | str, to: str, out: Path | str) -> Path:
    """Write the run in ``directory`` in the format ``to`` into the directory ``out``; returns what to open.

    Raises InputError if there is no such format, no such run, or nothing in it that the format could hold.
    """
    if to not in EXPORTS:
        raise InputError(f"there is no export to {to!r}, choose from {', '.join(EXPORTS)}")
    try:
        return EXPORTS[to](Path(directory), Path(out))
    except OSError as error:
        raise InputError(f"{out} cannot be written to: {error.strerror}") from error


__all__ = ["EXPORTS", "export_coco", "export_geojson", "export_images", "export_mot", "export_run"]
