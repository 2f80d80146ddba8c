"""Checks across the keys of a rig file."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from emg2vsa.devices.device_settings import LARGEST_PRESS_BYTES, CameraSettings
from emg2vsa.devices.netft import INTERNAL_RATE_HZ
from emg2vsa.devices.qbmove import QbmoveSettings
from emg2vsa.rig.experiment import ExperimentSettings, PlateSettings
from emg2vsa.rig.plan import RIGID
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.study_file.problems import KeyPath, Problem, nearest, shown
from emg2vsa.worlds.bench.controls import contradictions
from emg2vsa.worlds.bench.settings import VISCOELASTIC_KEYS, EmulatedSettings

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


def problems_across(tables: Mapping[str, Any], raw: Mapping[str, Any]) -> Iterator[Problem]:
    """``tables``: those of `RigTables` that could be made out. ``raw``: the file, which tells what was set in it."""
    if rig := tables.get("rig"):
        yield from _rig(rig)
    if experiment := tables.get("experiment"):
        yield from _names(experiment)
        yield from _angles(experiment)
        if rig:
            yield from _presses(experiment, rig)
            if plate := tables.get("plate"):
                yield from _plate(plate, rig)
        if camera := tables.get("camera"):
            yield from _frames(experiment, camera)
        yield from _of_specimens(experiment)
        yield from _motor(experiment, raw)
        yield from _emulated(experiment, tables, raw)
        yield from _control(experiment, tables, raw)
    yield from _one_board_each(tables)
    if rig:
        yield from _watchdogs(tables, rig)


def _rig(rig: RigSettings) -> Iterator[Problem]:
    for key in ("position_deg", "stiffness_percent"):
        first, last = getattr(rig, key)
        if first >= last:
            yield Problem(("rig", key), "the smaller of two different numbers first", shown([first, last]))
    length = math.hypot(*rig.push_axis)
    if not math.isclose(length, 1, rel_tol=1e-3):
        do = "Along z it is [0, 0, 1]."
        yield Problem(("rig", "push_axis"), "a direction of length 1", f"one of length {length:.4g}", do)
    low, high = rig.position_deg
    for key, depth_mm in (("home_deg", 0.0), ("travel_mm", rig.travel_mm)):
        position_deg = rig.position_at(depth_mm)
        if not low <= position_deg <= high:
            wanted = f"every depth within position_deg, {low:.6g} to {high:.6g}"
            yield Problem(("rig", key), wanted, f"{depth_mm:g} mm at {position_deg:.6g} degrees")
    if rig.escape_mm_per_s > rig.max_mm_per_s:
        yield Problem(("rig", "escape_mm_per_s"), _most_mm_per_s(rig), f"{rig.escape_mm_per_s:g}")
    if rig.guards.stale_s <= rig.period_s:
        wanted = f"more than a period of the loop, {rig.period_s:g} s"
        yield Problem(("rig", "guards", "stale_s"), wanted, f"{rig.guards.stale_s:g}")


def _most_mm_per_s(rig: RigSettings) -> str:
    return f"at most rig.max_mm_per_s, {rig.max_mm_per_s:g}"


def _watchdogs(tables: Mapping[str, Any], rig: RigSettings) -> Iterator[Problem]:
    for name in ("actuator", "motor"):
        board = tables.get(name)
        if board and rig.period_s > board.watchdog_s / 4:
            wanted = f"at least {4 / board.watchdog_s:g}, so that watchdog_s holds four turns of the loop"
            yield Problem(("rig", "rate_hz"), wanted, f"{rig.rate_hz:g}")
        if board and rig.guards.motors_every_s >= board.watchdog_s / 2:
            wanted = f"less than half of {name}.watchdog_s, {board.watchdog_s:g}: questions keep it from running out"
            yield Problem(("rig", "guards", "motors_every_s"), wanted, f"{rig.guards.motors_every_s:g}")


def _of_specimens(experiment: ExperimentSettings) -> Iterator[Problem]:
    for key in ("stiffness_n_per_mm", "schedule_of"):
        for name in getattr(experiment, key):
            if name not in experiment.specimens:
                do = nearest(name, experiment.specimens)
                yield Problem(("experiment", key, name), "a specimen of the experiment", shown(name), do)
    for name, other in experiment.schedule_of.items():
        if name == other:
            do = "Leave it out: a specimen is pressed with its own schedules where nothing is said."
            yield Problem(("experiment", "schedule_of", name), "another specimen", shown(other), do)


def _names(experiment: ExperimentSettings) -> Iterator[Problem]:
    for index, name in enumerate(experiment.specimens):
        at = ("experiment", "specimens", index)
        if not _NAME.fullmatch(name):
            wanted = "letters, digits, - _ and dots only, the first a letter or digit"
            yield Problem(at, wanted, shown(name))
        if name in experiment.specimens[:index]:
            yield Problem(at, "every name once", f"{name!r} again")


def _angles(experiment: ExperimentSettings) -> Iterator[Problem]:
    for condition, angles in experiment.angles_deg.items():
        for index, angle_deg in enumerate(angles):
            at: KeyPath = ("experiment", "angles_deg", condition, index)
            if angle_deg >= 90:
                yield Problem(at, "0 to below 90 degrees", f"{angle_deg:g}")
            if angle_deg in angles[:index]:
                yield Problem(at, "every angle once", f"{angle_deg:g} again")
    if not any(experiment.angles_deg.values()):
        yield Problem(("experiment", "angles_deg"), "an angle of one condition at least", "none")


def _presses(experiment: ExperimentSettings, rig: RigSettings) -> Iterator[Problem]:
    low, high = experiment.f_contact_n, rig.guards.force_n
    if not low < experiment.f_max_n < high:
        wanted = f"a force above contact, {low:g} N, and below the guard rig.guards.force_n, {high:g} N"
        yield Problem(("experiment", "f_max_n"), wanted, f"{experiment.f_max_n:g}")
    if experiment.ramp_mm_per_s > rig.max_mm_per_s:
        yield Problem(("experiment", "ramp_mm_per_s"), _most_mm_per_s(rig), f"{experiment.ramp_mm_per_s:g}")
    if experiment.travel_mm > rig.travel_mm:
        wanted = f"at most rig.travel_mm, {rig.travel_mm:g}"
        yield Problem(("experiment", "travel_mm"), wanted, f"{experiment.travel_mm:g}")


def _plate(plate: PlateSettings, rig: RigSettings) -> Iterator[Problem]:
    low, high = plate.f_contact_n, rig.guards.force_n
    if not low < plate.f_max_n < high:
        wanted = f"a force above contact, {low:g} N, and below the guard rig.guards.force_n, {high:g} N"
        yield Problem(("plate", "f_max_n"), wanted, f"{plate.f_max_n:g}")


def _frames(experiment: ExperimentSettings, camera: CameraSettings) -> Iterator[Problem]:
    longest_s = experiment.travel_mm / experiment.ramp_mm_per_s + experiment.contact_s
    size_bytes = longest_s * camera.rate_hz * camera.height * camera.width
    if size_bytes > LARGEST_PRESS_BYTES:
        found = f"up to {size_bytes / 2**30:.1f} GiB: {camera.width} x {camera.height} pixels for {longest_s:g} s"
        do = "Choose smaller frames, a lower rate_hz, or a faster ramp."
        yield Problem(("camera", "height"), "less than 4 GiB of frames in a press", found, do)


def _motor(experiment: ExperimentSettings, raw: Mapping[str, Any]) -> Iterator[Problem]:
    if experiment.angles_deg.get(RIGID) and "motor" not in raw:
        do = f"Add it, or give angles_deg without {RIGID}."
        yield Problem(("motor",), f"a table [motor], as the experiment has the condition {RIGID}", "nothing", do)


def _emulated(experiment: ExperimentSettings, tables: Mapping[str, Any], raw: Mapping[str, Any]) -> Iterator[Problem]:
    emulated = tables.get("emulated")
    if emulated is None:
        return
    yield from _emulated_specimens(experiment, emulated)
    yield from _emulated_skin(emulated)
    yield from _emulated_bench(experiment, emulated, tables.get("rig"))
    actuator, told = tables.get("actuator"), "springs" in raw["emulated"]
    if told and isinstance(actuator, QbmoveSettings) and emulated.springs != actuator.joint:
        wanted = f'{actuator.joint}, as [actuator] has the model "{actuator.model}"'
        do = "Leave springs out, or correct [actuator]."
        yield Problem(("emulated", "springs"), wanted, shown(emulated.springs), do)


def _emulated_specimens(experiment: ExperimentSettings, emulated: EmulatedSettings) -> Iterator[Problem]:
    """Each specimen has a stiffness, and nothing else is said of one without."""
    at: KeyPath = ("emulated", "stiffness_n_per_mm")
    for name in experiment.specimens:
        if name not in emulated.stiffness_n_per_mm:
            do = nearest(name, emulated.stiffness_n_per_mm)
            yield Problem((*at, name), f"the stiffness of every specimen, {name} too", "nothing", do)
    known = emulated.stiffness_n_per_mm
    for key in ("height_mm", "relaxation"):
        for name in getattr(emulated, key):
            if name not in known:
                wanted = "a specimen of stiffness_n_per_mm"
                yield Problem(("emulated", key, name), wanted, shown(name), nearest(name, known))


def _emulated_skin(emulated: EmulatedSettings) -> Iterator[Problem]:
    """Keys that the chosen world and skin have."""
    if emulated.world == "elastic":
        usual = EmulatedSettings()
        for key in VISCOELASTIC_KEYS:
            if (found := getattr(emulated, key)) != getattr(usual, key):
                do = 'Remove the key, or set world to "viscoelastic".'
                yield Problem(("emulated", key), 'a key that world = "elastic" has', shown(found), do)
    if emulated.dome_radius_mm != EmulatedSettings.dome_radius_mm and not emulated.domes:
        do = "Give domes, or leave dome_radius_mm out."
        yield Problem(("emulated", "dome_radius_mm"), "it beside domes", shown(emulated.dome_radius_mm), do)
    if emulated.domes and emulated.skin != "finite-elements":
        wanted, do = 'skin = "finite-elements" beside it', "Leave one of the two out."
        yield Problem(("emulated", "domes"), wanted, shown(emulated.skin), do)


def _emulated_bench(
    experiment: ExperimentSettings, emulated: EmulatedSettings, rig: RigSettings | None
) -> Iterator[Problem]:
    """Rates, gaps, angles and friction that the emulated bench can have."""
    parts = INTERNAL_RATE_HZ / emulated.force_rate_hz
    if not math.isclose(parts, round(parts), rel_tol=1e-9):
        near = INTERNAL_RATE_HZ / max(1, math.floor(parts))
        wanted = f"a whole fraction of {INTERNAL_RATE_HZ:g}, as {near:g}"
        yield Problem(("emulated", "force_rate_hz"), wanted, shown(emulated.force_rate_hz))
    furthest_mm = emulated.gap_mm + 2 * emulated.gap_sd_mm
    if rig and furthest_mm > rig.guards.contact_mm:
        wanted = f"contact within rig.guards.contact_mm, {rig.guards.contact_mm:g} mm"
        found = f"it after up to {furthest_mm:g} mm (gap_mm and 2 gap_sd_mm)"
        yield Problem(("emulated", "gap_mm"), wanted, found, "Choose a smaller gap, or a later guard.")
    widest = max((deg for angles in experiment.angles_deg.values() for deg in angles if deg < 90), default=0.0)
    if widest + 2 * emulated.angle_sd_deg >= 90:
        wanted = f"an angle_sd_deg of which two added to {widest:g} degrees stay below 90"
        yield Problem(("emulated", "angle_sd_deg"), wanted, shown(emulated.angle_sd_deg))
    if not 2 * emulated.friction_drop <= emulated.friction and (emulated.friction > 0):
        wanted = f"at most half of emulated.friction, {emulated.friction:g}"
        yield Problem(("emulated", "friction_drop"), wanted, shown(emulated.friction_drop))


def _control(experiment: ExperimentSettings, tables: Mapping[str, Any], raw: Mapping[str, Any]) -> Iterator[Problem]:
    emulated = tables.get("emulated")
    if emulated is None:
        return
    for key, wanted, do in contradictions(emulated, raw["emulated"]):
        yield Problem(("emulated", key), wanted, shown(getattr(emulated, key)), do)
    if emulated.control == "N3" and experiment.schedule_of:
        wanted = 'no schedule_of beside control = "N3", which swaps the schedules itself'
        found = ", ".join(f"{one} = {other}" for one, other in experiment.schedule_of.items())
        yield Problem(("experiment", "schedule_of"), wanted, found, "Leave it out, or choose another control.")


def _one_board_each(tables: Mapping[str, Any]) -> Iterator[Problem]:
    actuator, motor = tables.get("actuator"), tables.get("motor")
    if actuator and motor and actuator.port and (actuator.port, actuator.id) == (motor.port, motor.id):
        do = "Give one of them another id; emg2vsa rig scan lists who answers."
        yield Problem(("motor", "id"), "a board of its own", f"id {motor.id} at {motor.port}, as for [actuator]", do)
