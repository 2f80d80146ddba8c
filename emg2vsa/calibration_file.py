"""Calibrations as JSON files: what ``emg2vsa run`` writes for every angle and condition, and a press is judged by.

One object: ``format``, ``version``, what was measured (quantity, area_unit, angle_deg, condition, force_n),
``settings`` (those of [calibration]), ``specimens`` with kappa and the rates of their presses at every force,
``pins`` (what ``casr.kappa.known.KnownSensor`` holds; null where the pins say nothing), ``provenance``, and ``sha256``
of the rest. NaN is null. Numbers read back as the same doubles. A file that
was changed, or is of another version, is refused.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from casr.atomic import write_text_atomic
from casr.camera import KEYS, Camera, Sensor
from casr.kappa.known import KnownSensor, ToldPress
from emg2vsa.arrays import Floats, Ints
from emg2vsa.calibration.laws import LAWS, WAYS
from emg2vsa.calibration.online import OnlineCalibration, reachable_width
from emg2vsa.calibration.online_pins import KnownPins
from emg2vsa.errors import DataError
from emg2vsa.run_scores import ALGORITHMS
from emg2vsa.settings import CalibrationSettings

FORMAT, VERSION = "emg2vsa calibration", 2
_AGAIN = "Write the calibration again with emg2vsa run."
_MOST_BYTES = 50_000_000
_MOST = 1e9
"""No force, stiffness or rate is so large."""


def file_name(calibration: OnlineCalibration) -> str:
    """``modular_30.json``."""
    return f"{calibration.condition}_{calibration.angle_deg:g}.json"


def write_calibration(path: Path, calibration: OnlineCalibration) -> Path:
    """Write one calibration, atomically; its path. OSError as ``casr.atomic``."""
    document = _document_of(calibration)
    document["sha256"] = _digest(document)
    write_text_atomic(path, json.dumps(document, indent=1, allow_nan=False) + "\n")
    return path


def open_calibration(path: Path) -> OnlineCalibration:
    """What ``write_calibration`` wrote. DataError that names the file, the key, what was wanted and found."""
    document = _json(path)
    seal = document.pop("sha256", None)
    _expect(path, "format", document.get("format"), repr(FORMAT), document.get("format") == FORMAT)
    version = document.get("version")
    _expect(path, "version", version, f"version {VERSION}", version == VERSION and not isinstance(version, bool))
    if seal != _digest(document):
        raise DataError(f"{path}, sha256", wanted="the digest of the content", found=repr(seal), do=_AGAIN)
    try:
        calibration = _calibration_of(document, path)
    except (KeyError, TypeError, AttributeError, ValueError, IndexError, OverflowError) as error:
        raise DataError(path, wanted="the keys of a calibration", found=f"{error!r}", do=_AGAIN) from error
    _expect_use(path, calibration)
    return calibration


def _expect_use(path: Path, calibration: OnlineCalibration) -> None:
    """DataError where kappa could not be told by it."""
    if not calibration.rises:
        do = "Check the stiffnesses of the specimens in the study, and write the calibration again with emg2vsa run."
        raise DataError(f"{path}, specimens", wanted="CASR that rises with softness", found="one that does not", do=do)
    with np.errstate(all="ignore"):
        try:
            width = reachable_width(calibration)
        except (ValueError, FloatingPointError) as error:
            raise DataError(path, wanted="a law that can be fitted", found=str(error), do=_AGAIN) from error
    _expect(path, "specimens", width, "presses that tell a stiffness", not math.isnan(width))


def sha256_of(calibration: OnlineCalibration) -> str:
    """Digest as the file of the calibration states it."""
    return _digest(_document_of(calibration))


def _document_of(calibration: OnlineCalibration) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "version": VERSION,
        "quantity": calibration.quantity,
        "area_unit": calibration.area_unit,
        "angle_deg": calibration.angle_deg,
        "condition": calibration.condition,
        "simulated": calibration.simulated,
        "force_n": {"start": calibration.start_n, "judged_at": calibration.forces_n.tolist()},
        "settings": dataclasses.asdict(calibration.settings),
        "growth_power": calibration.growth if math.isfinite(calibration.growth) else None,
        "specimens": [
            {
                "name": name,
                "kappa_n_per_mm": float(calibration.kappa[s]),
                "kappa_se_n_per_mm": float(calibration.kappa_se[s]),
                "presses": [
                    {"mounting": int(mounting), "rates": _numbers(rates)}
                    for mounting, rates in zip(calibration.mounting[s], calibration.rates[s], strict=True)
                    if mounting > 0
                ],
            }
            for s, name in enumerate(calibration.specimens)
        ],
        "pins": None if calibration.pins is None else _document_of_pins(calibration.pins),
        "provenance": dict(calibration.provenance),
    }


def _document_of_pins(pins: KnownPins) -> dict[str, Any]:
    sensor, lower = dataclasses.asdict(pins.sensor), np.tril_indices(pins.sensor.mean.size)
    sensor |= {"mean": pins.sensor.mean.tolist(), "precision": pins.sensor.precision[lower].tolist()}
    camera = {key: getattr(pins.camera, key) for key in KEYS} | {"sensor": pins.camera.sensor.known()}
    return {"tables": pins.tables, "camera": json.loads(json.dumps(camera)), "sensor": sensor}


def _numbers(values: Floats) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values.tolist()]


def _digest(document: dict[str, Any]) -> str:
    text = json.dumps(document, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _json(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise DataError(path, wanted="a calibration file", found="more than 50 MB", do=_AGAIN)
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        found = error.strerror if isinstance(error, OSError) else "bytes that are not text"
        raise DataError(path, wanted="a calibration file", found=str(found), do=_AGAIN) from error
    try:
        document = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise DataError(path, wanted="a JSON object", found=str(error), do=_AGAIN) from error
    if not isinstance(document, dict):
        raise DataError(path, wanted="a JSON object", found=type(document).__name__, do=_AGAIN)
    return document


def _no_number(name: str) -> float:
    raise ValueError(f"{name}, which JSON does not have")


def _expect(path: Path, key: str, found: object, wanted: str, holds: bool) -> None:
    if not holds:
        raise DataError(f"{path}, {key}", wanted=wanted, found=repr(found), do=_AGAIN)


def _settings(path: Path, document: dict[str, Any]) -> CalibrationSettings:
    """DataError : quantity, unit or a setting is out of its range."""
    settings = CalibrationSettings(**document["settings"])
    _expect(path, "quantity", document["quantity"], " or ".join(ALGORITHMS), document["quantity"] in ALGORITHMS)
    _expect(path, "area_unit", document["area_unit"], "mm2 or px2", document["area_unit"] in ("mm2", "px2"))
    _expect(path, "settings, confidence", settings.confidence, "a share between 0 and 1", 0 < settings.confidence < 1)
    for name, high in (("angle_sd_deg", 90), ("mounting_sd_percent", 50), ("outlier_mads", math.inf)):
        value = getattr(settings, name)
        _expect(path, f"settings, {name}", value, f"0 to below {high:g}", 0 <= value < high)
    ways = WAYS[settings.law] if settings.law in LAWS else ()
    _expect(path, "settings", settings.law, "a law that can be fitted", settings.minimise in ways)
    return settings


def _calibration_of(document: dict[str, Any], path: Path) -> OnlineCalibration:
    settings = _settings(path, document)
    forces = np.array(document["force_n"]["judged_at"], dtype=np.float64)
    start_n = float(document["force_n"]["start"])
    rise = forces.ndim == 1 and forces.size > 0 and bool(np.all(np.diff([start_n, *forces]) > 0)) and start_n > 0
    rise = rise and bool(forces[-1] < _MOST)
    angle_deg = float(document["angle_deg"])
    _expect(path, "angle_deg", angle_deg, "0 to below 90", 0 <= angle_deg < 90)
    _expect(path, "force_n", document["force_n"], "rising forces above 0", rise)
    known: list[dict[str, Any]] = document["specimens"]
    _expect(path, "specimens", len(known), "two specimens or more", len(known) >= 2)
    kappa = np.array([each["kappa_n_per_mm"] for each in known], dtype=np.float64)
    _expect(path, "kappa_n_per_mm", kappa.tolist(), "stiffnesses above 0", bool(np.all((kappa > 0) & (kappa < _MOST))))
    _expect(path, "kappa_n_per_mm", kappa.tolist(), "two different stiffnesses or more", np.unique(kappa).size >= 2)
    errors = np.array([each["kappa_se_n_per_mm"] for each in known], dtype=np.float64)
    fits = bool(np.all((errors >= 0) & (errors < _MOST)))
    _expect(path, "kappa_se_n_per_mm", errors.tolist(), "standard errors from 0", fits)
    rates, mounting = _presses(path, [each["presses"] for each in known], forces.size)
    return OnlineCalibration(
        specimens=tuple(str(each["name"]) for each in known),
        kappa=kappa,
        kappa_se=errors,
        quantity=document["quantity"],
        area_unit=document["area_unit"],
        angle_deg=angle_deg,
        condition=str(document["condition"]),
        start_n=start_n,
        forces_n=forces,
        rates=rates,
        mounting=mounting,
        settings=settings,
        growth=_number(document["growth_power"]),
        simulated=bool(document["simulated"]),
        provenance={str(name): str(value) for name, value in document["provenance"].items()},
        pins=None if document["pins"] is None else _pins(path, document["pins"]),
    )


def _pins(path: Path, told: dict[str, Any]) -> KnownPins:
    sensor = dict(told["sensor"])
    mean = np.array(sensor.pop("mean"), dtype=np.float64)
    precision = np.zeros((mean.size, mean.size))
    precision[np.tril_indices(mean.size)] = np.array(sensor.pop("precision"), dtype=np.float64)
    precision += np.tril(precision, -1).T
    presses = tuple(ToldPress(**each) for each in sensor.pop("presses"))
    found = KnownSensor(
        presses=presses, mountings=tuple(sensor.pop("mountings")), mean=mean, precision=precision, **sensor
    )  # fmt: skip
    fits = mean.size == found.z_at[-1] + 1 + found.with_force.size and bool(np.all(np.linalg.eigvalsh(precision) > 0))
    _expect(path, "pins", mean.size, "a positive precision of its parameters", fits)
    camera = told["camera"]
    return KnownPins(found, Camera(**camera | {"sensor": Sensor(**camera["sensor"])}), str(told["tables"]))


def _presses(path: Path, known: Sequence[Sequence[dict[str, Any]]], forces: int) -> tuple[Floats, Ints]:
    """Rates (S, R, G), and mountings (S, R)."""
    most = max((len(presses) for presses in known), default=0)
    rates, mounting = np.full((len(known), most, forces), np.nan), np.zeros((len(known), most), dtype=np.int64)
    for s, presses in enumerate(known):
        for r, press in enumerate(presses):
            where = f"specimens {s + 1}, press {r + 1}"
            count = len(press["rates"])
            _expect(path, where, count, f"{forces} rates", count == forces)
            rates[s, r] = [_number(value) for value in press["rates"]]
            _expect(path, f"{where}, rates", press["rates"], "numbers", bool(np.all(~(np.abs(rates[s, r]) >= _MOST))))
            _expect(path, where, press["mounting"], "a mounting from 1", press["mounting"] >= 1)
            mounting[s, r] = press["mounting"]
        last = int(np.count_nonzero(np.isfinite(rates[s, :, -1:])))
        _expect(path, f"specimens {s + 1}", last, "one press or more that reaches the largest force", last > 0)
    return rates, mounting


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)
