"""camera.toml: the intrinsics, distortion and depth of a tactile camera."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

from casr.atomic import write_text_atomic
from casr.camera import Camera
from casr.errors import CameraError, said_of

_KEYS = [field.name for field in fields(Camera)]
# what may be left out: undistorted frames need no coefficients, and areas no frame rate
_OPTIONAL = {"distortion", "frame_rate_hz"}


def read_camera(path: Path | str) -> Camera:
    """A camera from the table ``[camera]`` of a TOML file; its keys are the fields of `Camera`.

    ``distortion`` and ``frame_rate_hz`` may be left out. Other tables of the file are not looked at.

    Raises
    ------
    CameraError : not readable, not TOML, no ``[camera]``, an unknown or missing key, a value that makes no sense.
    """
    path = Path(path)
    table = _table(path)
    for key in table:
        if key not in _KEYS:
            near = [known for known in _KEYS if known.startswith(key)] or difflib.get_close_matches(key, _KEYS, n=1)
            raise CameraError(
                f"{path}, [camera] {key}",
                wanted=f"one of {', '.join(_KEYS)}",
                found=f"the unknown key {key}",
                do=f"Did you mean {near[0]}?" if near else "Remove it.",
            )
    missing = [key for key in _KEYS if key not in table and key not in _OPTIONAL]
    if missing:
        raise CameraError(
            f"{path}, [camera]",
            wanted=f"the keys {', '.join(missing)}",
            found="none of them" if len(missing) > 1 else "nothing",
            do="Add them; millimetres cannot be told without.",
        )
    with said_of(path):
        return Camera(**table)


def write_camera(path: Path | str, camera: Camera) -> None:
    """Write a camera so that `read_camera` gives back the very same one."""
    write_text_atomic(Path(path), camera.to_toml())


def _table(path: Path) -> dict[str, Any]:
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise CameraError(
            path, wanted="a camera file", found=error.strerror or str(error), do="Check the path."
        ) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CameraError(path, wanted="a TOML file", found=str(error), do="Correct the file.") from error
    table = tables.get("camera")
    if not isinstance(table, dict):
        raise CameraError(
            path,
            wanted="a table [camera]",
            found=f"the keys {', '.join(tables)}" if tables else "no keys",
            do="Write the line [camera] above the camera's keys.",
        )
    return table
