"""The actuator's map from preset to stiffness and back; contacts and relaxation over extreme forces and times."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from mpmath import mp, mpf

from benchmarks.stress.case import Case, Found
from benchmarks.stress.exact_curves import mpfs
from emg2vsa.devices.qbmove.springs import MOTOR_LIMIT_TICKS, SPRINGS, SpringJoint
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK, TICKS_PER_TURN
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.worlds.contact import ConvolvedForce, Relaxation, adhesive_force_n


def cases() -> Iterator[Case]:
    for model in SPRINGS:
        yield from _actuator(model)
    for modulus, force, bound in ((0.1, 7.0, 14.0), (1e-9, 1e-12, 13.0), (1e9, 1e6, 13.0), (0.1, 1e-300, 11.0)):
        yield contact_case(modulus, force, bound)
    for adhesion, force, bound in ((50.0, 1.0, 15.0), (1e-6, 1e9, 15.0), (1e9, 1e-9, 15.0)):
        yield _adhesion(adhesion, force, bound)
    for time_s, bound, smoke in ((1.0, 12.0, True), (1e-9, 12.0, False), (1e9, 12.0, False)):
        yield relaxation_case(time_s, bound, smoke)
    for step_s, steps, bound, smoke in ((0.005, 400, 13.0, True), (1e-6, 400, 13.0, False), (1e3, 20, 13.0, False)):
        yield convolved_case(step_s, steps, bound, smoke)


def exact_stiffness(ticks: Any, model: str) -> Any:
    """Sum of the springs' stiffnesses where their torques cancel."""
    springs = SPRINGS[model]
    k1, a1, k2, a2 = (mpf(v) for v in (springs.k1_nm, springs.a1_per_rad, springs.k2_nm, springs.a2_per_rad))
    preset = abs(ticks) * 2 * mp.pi / TICKS_PER_TURN

    def torque(d: Any) -> Any:
        return k1 * mp.sinh(a1 * (d - preset)) + k2 * mp.sinh(a2 * (d + preset))

    def slope(d: Any) -> Any:
        return a1 * k1 * mp.cosh(a1 * (d - preset)) + a2 * k2 * mp.cosh(a2 * (d + preset))

    low, high = -preset - 1, preset + 1
    at = mpf(0)
    for _ in range(400):
        step = torque(at) / slope(at)
        if abs(step) < mpf("1e-45"):
            break
        # torque rises: Newton, and half of the interval where it leaves it
        low, high = (at, high) if step < 0 else (low, at)
        at = at - step if low < at - step < high else (low + high) / 2
    return slope(at)


def _actuator(model: str) -> Iterator[Case]:
    joint = SpringJoint(model, MOTOR_LIMIT_TICKS * DEG_PER_TICK)
    for ticks, bound, smoke in (
        ([0.0, 1.0], 13.0, True),
        ([500.0, 3000.0], 12.0, True),
        ([MOTOR_LIMIT_TICKS * 1.0], 12.0, False),
    ):
        yield Case(
            "springs.stiffness_nm_per_rad",
            f"{model}, presets {ticks} ticks",
            (np.array(ticks),),
            lambda x: Found({"stiffness": joint.stiffness_nm_per_rad(x / MOTOR_LIMIT_TICKS)}),
            lambda x: {"stiffness": [exact_stiffness(value, model) for value in mpfs(x)]},
            bound,
            smoke=smoke,
        )
    for ticks, bound in ((3.0, 6.0), (1000.0, 9.0), (14000.0, 9.0)):
        wanted = joint.stiffness_nm_per_rad(ticks / MOTOR_LIMIT_TICKS).reshape(1)
        yield Case(
            "springs.percent_for",
            f"{model}, preset near {ticks:g}; error in ticks",
            (wanted,),
            lambda x: Found({"preset": joint.percent_for(x) / 100 * MOTOR_LIMIT_TICKS}),
            lambda x, near=ticks: {"preset": [_exact_preset(mpfs(x)[0], model, near)]},
            bound,
            size=1.0,
        )


def _exact_preset(wanted: Any, model: str, near: float) -> Any:
    low, high = mpf(near) * mpf("0.9"), mpf(near) * mpf("1.1")
    return mp.findroot(
        lambda t: mp.log(exact_stiffness(t, model) / wanted), (low, high), solver="anderson", tol=mpf("1e-60")
    )


def contact_case(modulus: float, force: float, bound: float) -> Case:
    """Depth, area and back to force."""

    def ours(x: np.ndarray) -> Found:
        law = PowerLaw(x[0], 20.0, 0.25)
        return Found(
            {"depth": law.depth_mm(x[1]), "area": law.area_mm2(x[1]), "force": law.force_n(law.depth_mm(x[1]))}
        )

    def exact(x: np.ndarray) -> dict[str, Any]:
        (e, f), r, n = mpfs(x), mpf(20), mpf(1) / 4
        c = 3 / (4 * e * r**2)
        return {
            "depth": f ** (1 - n) / (2 * (1 - n) * e * r * c**n),
            "area": mp.pi * (r * (c * f) ** n) ** 2,
            "force": f,
        }

    return Case(
        "contact_mechanics.PowerLaw",
        f"E* {modulus:g} MPa, {force:g} N",
        (np.array([modulus, force]),),
        ours,
        exact,
        bound,
        smoke=force == 7.0,
    )


def _adhesion(adhesion: float, force: float, bound: float) -> Case:
    def exact(x: np.ndarray) -> dict[str, Any]:
        w = 3 * mp.pi * mpf(adhesion) * 20 / 10**6
        f = mpfs(x)[0]
        return {"force": f + w + mp.sqrt(2 * w * f + w * w)}

    return Case(
        "contact_mechanics.adhesive_force_n",
        f"{adhesion:g} mJ/m2, {force:g} N",
        (np.array([force]),),
        lambda x: Found({"force": adhesive_force_n(float(x[0]), adhesion)}),
        exact,
        bound,
    )


def relaxation_case(time_s: float, bound: float, smoke: bool) -> Case:
    """Modulus after a step of depth: the system of branches solved in 50 digits."""
    body = Relaxation.of_share(0.4)

    def exact(x: np.ndarray) -> dict[str, Any]:
        taus, branches = [mpf(tau) for tau in body.taus_s], [mpf(b) for b in body.branches]
        root = [mp.sqrt(b / tau / mpf(body.instant)) for b, tau in zip(branches, taus, strict=True)]
        n = len(taus)
        system = mp.matrix(n, n)
        for i in range(n):
            for j in range(n):
                system[i, j] = root[i] * root[j] + (1 / taus[i] if i == j else 0)
        rates, across = mp.eigsy(system)
        gone = mpf(0)
        for i in range(n):
            load = mp.fsum(across[j, i] * root[j] for j in range(n))
            gone += -mp.expm1(-mpfs(x)[0] * rates[i]) / rates[i] * load**2
        return {"modulus": (1 - gone) / mpf(body.instant)}

    return Case(
        "contact_mechanics.Relaxation.modulus",
        f"after {time_s:g} s",
        (np.array([time_s]),),
        lambda x: Found({"modulus": body.modulus(x)}),
        exact,
        bound,
        smoke=smoke,
    )


def convolved_case(step_s: float, steps: int, bound: float, smoke: bool) -> Case:
    """Force that grows evenly: the convolved force after so many steps, against its integral in one step."""
    body = Relaxation.of_share(0.4)

    def ours(x: np.ndarray) -> Found:
        contact = ConvolvedForce([body])
        for i in range(steps):
            found = contact.advance(step_s, x * (i + 1) / steps)
        return Found({"force": found[0]})

    def exact(x: np.ndarray) -> dict[str, Any]:
        total_s, force = mpf(step_s) * steps, mpfs(x)[0]
        parts = [
            mpf(b) * (1 + mpf(tau) / total_s * mp.expm1(-total_s / mpf(tau)))
            for b, tau in zip(body.branches, body.taus_s, strict=True)
        ]
        return {"force": force * (mpf(body.instant) + mp.fsum(parts))}

    return Case(
        "contact_mechanics.ConvolvedForce",
        f"{steps} steps of {step_s:g} s",
        (np.array([7.0]),),
        ours,
        exact,
        bound,
        smoke=smoke,
    )
