"""Stiffness: what that of the actuator can do to the spread rates of the study's specimens, by mechanics alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.shared_settings import emulated_domes
from emg2vsa.pipeline.stage import Given, Keyed, Stage
from emg2vsa.settings import RIGID

if TYPE_CHECKING:
    from emg2vsa.arrays import Floats
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.stiffness_effect import StiffnessEffect
    from emg2vsa.worlds.contact import StiffnessSteps


def settings(campaign: Campaign, item: str) -> dict[str, Any]:
    """Settings of the bench that decide how it moves and creeps, without its scatter and its devices."""
    from emg2vsa.devices.device_settings import RATE_HZ

    assert campaign.rig is not None
    assert campaign.rig.emulated is not None
    rig, emulated, experiment = campaign.rig, campaign.rig.emulated.as_used(), campaign.rig.experiment
    known = [name for name in experiment.specimens if name in emulated.stiffness_n_per_mm]
    return {
        "stiffness": {name: emulated.stiffness_n_per_mm[name] for name in known},
        "relaxation": {name: emulated.relaxation_of(name) for name in known},
        "sensor_relaxation": emulated.sensor_relaxation,
        "skin": emulated.skin,
        **({"domes": Keyed(emulated.domes, True)} if emulated.domes else {}),
        "dome_radius_mm": emulated.dome_radius_mm,
        "height_mm": {name: emulated.height_mm.get(name) for name in known if emulated.domes},
        "springs": emulated.springs,
        "preset_latency_s": emulated.preset_latency_s,
        "camera": (emulated.camera_latency_sd_s, emulated.camera_jitter_s, emulated.force_noise_n),
        "gear_mm_per_degree": rig.rig.gear_mm_per_degree,
        "ramp_mm_per_s": experiment.ramp_mm_per_s,
        "window_n": (experiment.f_contact_n, experiment.f_max_n),
        "rate_hz": rig.devices.camera.rate_hz if rig.devices.camera else RATE_HZ,
        "percent": campaign.study.schedule.stiffness_percent,
        "max_preset_ticks": campaign.study.schedule.max_preset_ticks,
    }


def run(given: Given) -> StiffnessEffect | None:
    """None where fewer than two specimens have all schedules."""
    from emg2vsa.devices.qbmove.springs import SPRINGS
    from emg2vsa.worlds.contact import Drive
    from emg2vsa.worlds.contact.stiffness_effect import AREA_NOISE, Bench, FrameErrors, materials_of, stiffness_effect
    from emg2vsa.worlds.tactile import ContactWorld

    used, world = given.settings, ContactWorld()
    steps = _steps(given)
    by_stiffness = sorted(used["stiffness"].items(), key=lambda each: -each[1])
    stiffness = {name: each for name, each in by_stiffness if all(name in own for own in steps.values())}
    if len(stiffness) < 2:
        return None
    for percent in used["percent"]:
        steps[f"all-{percent:g}"] = dict.fromkeys(stiffness, _constant(used, percent))
    bench = Bench(
        stiffness_mpa={name: world.specimen_mpa(each) for name, each in stiffness.items()},
        sensor_mpa=world.sensor_modulus_mpa,
        tip_radius_mm=world.tip_radius_mm,
        exponent=world.exponent,
        area_mm2=_areas(used, stiffness),
        drive=Drive(
            springs=SPRINGS[used["springs"]], speed_mm_per_s=used["ramp_mm_per_s"],
            mm_per_degree=used["gear_mm_per_degree"], preset_latency_s=used["preset_latency_s"],
        ),
        steps=steps,
        window_n=used["window_n"],
        rate_hz=used["rate_hz"],
    )  # fmt: skip
    latency_sd_s, jitter_s, force_n = used["camera"]
    errors = FrameErrors(area_share=AREA_NOISE, force_n=force_n, latency_sd_s=latency_sd_s, jitter_s=jitter_s)
    return stiffness_effect(bench, materials_of(used["sensor_relaxation"], used["relaxation"]), errors, RIGID)


def _steps(given: Given) -> dict[str, dict[str, StiffnessSteps]]:
    """By condition and specimen what the joint does; of another joint than one with springs, none for anything."""
    from emg2vsa.devices.qbmove.springs import SpringJoint
    from emg2vsa.schedules import Schedule
    from emg2vsa.worlds.contact import StiffnessSteps

    steps: dict[str, dict[str, StiffnessSteps]] = {}
    schedules: tuple[Schedule, ...] = given.one("schedules") or ()
    for schedule in schedules:
        own = steps.setdefault(schedule.condition, {})
        if not isinstance(joint := schedule.limits.joint, SpringJoint):
            return {schedule.condition: {}}
        own[schedule.specimen] = StiffnessSteps(schedule.step_force_n, joint.preset_rad(schedule.preset))
    return steps


def _constant(used: Mapping[str, Any], percent: float) -> StiffnessSteps:
    """What the joint does where it keeps that stiffness, as a part of its largest."""
    from emg2vsa.devices.qbmove.springs import SpringJoint
    from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
    from emg2vsa.worlds.contact import StiffnessSteps

    springs = SpringJoint(used["springs"], used["max_preset_ticks"] * DEG_PER_TICK)
    return StiffnessSteps.constant(float(springs.preset_rad(springs.rounded(percent / 100))))


def _areas(used: Mapping[str, Any], stiffness: Mapping[str, float]) -> Callable[[str, Floats], Floats]:
    """Contact area, mm2, of a specimen by name at forces (n,), N, on the skin of the settings."""
    import numpy as np

    from casr.dome.library import DEFAULT_WORLD
    from casr.dome.view import OUTER_RADIUS_MM
    from emg2vsa.worlds.tactile import ContactWorld, TabulatedWorld

    def area_mm2(name: str, force_n: Floats) -> Floats:
        if used["skin"] != "finite-elements":
            return ContactWorld().area_mm2(force_n, stiffness[name])
        scale, height_mm = used["dome_radius_mm"] / OUTER_RADIUS_MM, used["height_mm"].get(name)
        skin = TabulatedWorld(tables=used.get("domes", DEFAULT_WORLD))
        radius_mm = scale * skin.radius_mm(force_n, stiffness[name], height_mm and height_mm / scale)
        return np.asarray(np.pi * radius_mm**2)

    return area_mm2


def says(effect: StiffnessEffect | None) -> str:
    return "" if effect else "What stiffness can do is told of two specimens or more with schedules for springs."


STAGE = Stage(
    per="study", of="emulated rig", needs=("schedules",), run=run, settings=settings, files=emulated_domes, says=says,
    gives="What stiffness can do is",
)  # fmt: skip
