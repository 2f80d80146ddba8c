"""camera.toml: the intrinsics, distortion and depth of a tactile camera, and what is known of the sensor before it."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from casr.atomic import write_text_atomic
from casr.camera import KEYS, Camera, Sensor
from casr.errors import CameraError, said_of

# what may be left out: undistorted frames need no coefficients, areas no frame rate, and depth no standard error
_OPTIONAL = {"distortion", "frame_rate_hz", "depth_sd_mm"}
_SENSOR_KEYS = tuple(field.name for field in fields(Sensor))


def read_camera(path: Path | str) -> Camera:
    """A camera from the table ``[camera]`` of a TOML file, whose keys are the fields of `Camera`, and from its table
    ``[sensor]``, whose keys are those of `Sensor`.

    ``distortion``, ``frame_rate_hz`` and ``depth_sd_mm`` may be left out, and so may ``[sensor]`` and each of its keys.
    Other tables of the file are not looked at.

    Raises
    ------
    CameraError : not readable, not TOML, no ``[camera]``, an unknown or missing key, a value that makes no sense.
    """
    path = Path(path)
    tables = _tables(path)
    camera, sensor = tables["camera"], tables.get("sensor", {})
    if not isinstance(sensor, dict):
        raise CameraError(
            path, wanted="a table [sensor]", found=f"sensor = {sensor!r}", do="Write the line [sensor] above its keys."
        )
    _check_known(path, "camera", camera, KEYS)
    _check_known(path, "sensor", sensor, _SENSOR_KEYS)
    missing = [key for key in KEYS if key not in camera and key not in _OPTIONAL]
    if missing:
        raise CameraError(
            f"{path}, [camera]", wanted=f"the keys {', '.join(missing)}",
            found="none of them" if len(missing) > 1 else "none", do="Add them; millimetres cannot be told without.",
        )  # fmt: skip
    with said_of(path):
        return Camera(**camera, sensor=Sensor(**sensor))


def write_camera(path: Path | str, camera: Camera) -> None:
    """Write a camera so that `read_camera` gives back the very same one."""
    write_text_atomic(Path(path), camera.to_toml())


def _check_known(path: Path, name: str, table: dict[str, Any], keys: Sequence[str]) -> None:
    for key in table:
        if key not in keys:
            near = [known for known in keys if known.startswith(key)] or difflib.get_close_matches(key, keys, n=1)
            raise CameraError(
                f"{path}, [{name}] {key}", wanted=f"one of {', '.join(keys)}", found=f"the unknown key {key}",
                do=f"Did you mean {near[0]}?" if near else "Remove it.",
            )  # fmt: skip


def _tables(path: Path) -> dict[str, Any]:
    """Tables of the file; ``camera`` is one of them."""
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise CameraError(
            path, wanted="a camera file", found=error.strerror or str(error), do="Check the path."
        ) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CameraError(path, wanted="a TOML file", found=str(error), do="Correct the file.") from error
    if not isinstance(tables.get("camera"), dict):
        raise CameraError(
            path, wanted="a table [camera]", found=f"the keys {', '.join(tables)}" if tables else "no keys",
            do="Write the line [camera] above the camera's keys.",
        )  # fmt: skip
    return tables
