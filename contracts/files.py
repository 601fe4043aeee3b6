"""Files that are either whole or not there."""

from pathlib import Path

from contracts.errors import InputError


def write_whole(path: Path | str, content: str) -> None:
    """Write a text file, or leave what was there. Raises InputError naming the file if it cannot be written."""
    path = Path(path)
    partial = path.with_name(f".{path.name}.part")
    try:
        partial.write_text(content, encoding="utf-8")
        partial.replace(path)
    except OSError as error:
        if partial.is_file():
            partial.unlink()
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
