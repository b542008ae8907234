"""Files that a scene names: only those in the scene's own folder, or below it, are opened."""

from __future__ import annotations

from pathlib import Path, PurePosixPath, PureWindowsPath

from halftone.errors import InputFileError

__all__ = ["contents", "inside"]


def inside(folder: Path, reference: str, where: str) -> Path:
    """The path of *reference* in *folder*; refused where it is absolute, has ``..`` or leads out.

    where : the place that names it, for the message.
    """
    names = (PurePosixPath(reference), PureWindowsPath(reference))
    absolute = any(name.is_absolute() or name.drive or name.root for name in names)
    if not reference or "\0" in reference or absolute or any(".." in name.parts for name in names):
        raise _outside(folder, reference, where)
    path = folder / names[1 if "\\" in reference else 0].as_posix()
    try:
        path.resolve().relative_to(folder.resolve())  # a symbolic link may lead elsewhere
    except (ValueError, OSError, RuntimeError):
        raise _outside(folder, reference, where) from None
    return path


def contents(path: Path) -> bytes:
    """All bytes of a regular file."""
    try:
        if path.exists() and not path.is_file():
            raise InputFileError(f"{path} is not a file; allowed: a .toml, .obj, .mtl or .ply file")
        return path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, InputFileError):
            raise
        text = getattr(error, "strerror", None) or str(error)
        raise InputFileError(f"{path} cannot be read: {text}. Check the name and the rights") from error


def _outside(folder: Path, reference: str, where: str) -> InputFileError:
    return InputFileError(
        f"{where} names '{reference}', which is not inside the scene's folder {folder}; allowed: a "
        "relative path without '..'. Copy the file next to the scene"
    )
