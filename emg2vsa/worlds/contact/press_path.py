"""Presses without the rig's devices: drive, springs and contact stepped together, many presses at once.

The drive comes down at an even speed from first contact on, until the force along its axis has come by an end. A rigid
motor moves the probe with it. Springs stand between drive and probe otherwise; their preset follows a schedule by
force, late by the device's latency and no faster than its motors turn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casr.spread import fit_power_laws
from emg2vsa.arrays import Floats
from emg2vsa.devices.qbmove.springs import Springs, stiffness_at
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.errors import DataError
from emg2vsa.worlds.contact.relaxation import ConvolvedForce, Relaxation

_NEWTON = 40
_SOLVED_MM = _LEAST_MM = 1e-12
_GRID = 260
"Forces at which a spread rate takes areas."


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What moves the probe.

    Parameters
    ----------
    springs : between motors and probe; None is a rigid motor.
    speed_mm_per_s : of the drive along its axis. mm_per_degree : of the probe per turn of the shaft.
    friction_nm : Coulomb friction of the shaft.
    preset_latency_s : from a force to the preset that it asks for. motor_rad_per_s : how fast a preset changes.
    """

    springs: Springs | None = None
    speed_mm_per_s: float = 5.0
    mm_per_degree: float = 0.2
    friction_nm: float = 0.01
    preset_latency_s: float = 0.015
    motor_rad_per_s: float = 3.75


@dataclass(frozen=True, eq=False)
class StiffnessSteps:
    """Presets by force: ``presets_rad`` (K,) between ``edges_n`` (K + 1,). Loading never goes back a step."""

    edges_n: Floats
    presets_rad: Floats

    @classmethod
    def constant(cls, preset_rad: float) -> StiffnessSteps:
        """The same preset, rad, at every force."""
        return cls(np.array([0.0, math.inf]), np.array([preset_rad]))

    def preset_rad(self, force_n: float) -> float:
        """Preset, rad, at a force, N; below the first edge that of the first step, above the last that of the last."""
        return float(self.presets_rad[self._step(force_n)])

    def next_n(self, force_n: float) -> float:
        """Force, N, at which the next step begins; infinite in the last one."""
        step = self._step(force_n) + 1
        return float(self.edges_n[step]) if step < self.presets_rad.size else math.inf

    def _step(self, force_n: float) -> int:
        return min(max(int(self.edges_n.searchsorted(force_n, side="right")) - 1, 0), self.presets_rad.size - 1)


@dataclass(frozen=True, eq=False)
class PressPaths:
    """P presses from first contact on, NaN after the first sample at which a press has come by its end.

    time_s is (T,), all others (T, P): ``force_n`` of the contact; ``convolved_n``, which area and depth follow;
    ``area_mm2`` of the contact; ``preset_rad`` of the springs.
    """

    time_s: Floats
    force_n: Floats
    convolved_n: Floats
    area_mm2: Floats
    preset_rad: Floats

    def at_forces(self, values: Floats, force_n: Sequence[float] | Floats) -> Floats:
        """(N, P) ``values`` (T, P) where the force along the axis first comes by ``force_n`` (N,)."""
        found = np.empty((len(force_n), self.force_n.shape[1]))
        for p in range(found.shape[1]):
            known = np.isfinite(self.force_n[:, p])
            found[:, p] = np.interp(force_n, np.maximum.accumulate(self.force_n[known, p]), values[known, p])
        return found

    def duration_s(self, low_n: float = 0.5, high_n: float = 7.0) -> Floats:
        """(P,) s from one force to the other, N."""
        times = np.broadcast_to(self.time_s[:, None], self.force_n.shape)
        first, last = self.at_forces(times, [low_n, high_n])
        return np.asarray(last - first)

    def rate_mm2_per_n(self, low_n: float = 0.5, high_n: float = 7.0) -> Floats:
        """(P,) spread rate of the contact, mm2/N, between two forces, N, as scores have it (in place of the paper's
        equation 2)."""
        force_n = np.linspace(low_n, high_n, _GRID)
        return fit_power_laws(self.at_forces(self.area_mm2, force_n).T, force_n).mean_rates(low_n, high_n)


def simulate_presses(
    contacts: Sequence[PowerLaw],
    relaxation: Relaxation | Sequence[Relaxation],
    drive: Drive,
    steps: Sequence[StiffnessSteps] = (),
    *,
    f_max_n: float = 7.0,
    step_s: float = 1e-3,
    longest_mm: float = 25.0,
) -> PressPaths:
    """One press on each of the ``contacts`` (P,), springs with the ``steps`` (P,) of each; one ``relaxation``, or (P,).

    Time goes in steps of ``step_s``, s, each exact for a force that grows evenly within it. DataError where springs
    have no steps, or a press does not come to ``f_max_n``, N, within ``longest_mm``, mm, of the ramp.
    """
    longest_s = longest_mm / drive.speed_mm_per_s
    presses = _Presses(contacts, relaxation, drive, steps, step_s)
    rows = [presses.row()]
    while not (ended := presses.force_n >= f_max_n).all():
        if len(rows) * step_s > longest_s:
            raise DataError(
                "simulated press", wanted=f"{f_max_n:g} N within {longest_s:g} s",
                found=f"{presses.force_n[~ended].min():.3g} N", do="Press for longer, faster or less hard.",
            )  # fmt: skip
        presses.step()
        rows.append(presses.row())
    table = np.array(rows)
    came_by = np.cumsum(table[:, 0] >= f_max_n, axis=0) > 1
    table[np.broadcast_to(came_by[:, None], table.shape)] = np.nan
    force_n, convolved_n, preset_rad = np.moveaxis(table, 1, 0)
    area_mm2 = np.stack([contact.area_mm2(column) for contact, column in zip(contacts, convolved_n.T, strict=True)], 1)
    time_s = np.arange(len(rows), dtype=np.float64) * step_s
    return PressPaths(time_s, force_n, convolved_n, area_mm2, preset_rad)


class _Presses:
    """Where all presses are."""

    def __init__(
        self,
        contacts: Sequence[PowerLaw],
        relaxation: Relaxation | Sequence[Relaxation],
        drive: Drive,
        steps: Sequence[StiffnessSteps],
        step_s: float,
    ) -> None:
        if drive.springs is not None and len(steps) != len(contacts):
            raise DataError(
                "simulated presses", wanted=f"the stiffness of springs for each of {len(contacts)} presses",
                found=str(len(steps)), do="Give one schedule for each press.",
            )  # fmt: skip
        self.drive, self._step_s, self._steps = drive, step_s, steps
        self._per_mm = np.array([contact.per_mm for contact in contacts])
        self._power = np.array([contact.power for contact in contacts])
        self._mm_per_rad = math.degrees(drive.mm_per_degree)
        zero = np.zeros(len(contacts))
        bodies = [relaxation] * len(contacts) if isinstance(relaxation, Relaxation) else relaxation
        self._convolved = ConvolvedForce(bodies)
        self._alpha_n, self._beta = zero, zero + 1
        self.force_n, self._way_mm, self._convolved_n, self._count = zero, zero, zero, 0
        self._preset_rad = np.array([step.preset_rad(0.0) for step in steps]) if drive.springs else zero * np.nan
        self._commanded = [self._preset_rad]
        self._next_n = np.array([step.next_n(0.0) for step in steps])
        self._last_mm = np.full(zero.shape, drive.speed_mm_per_s * step_s)
        self._start_rad = self._balanced_rad()

    def row(self) -> tuple[Floats, ...]:
        return self.force_n, self._convolved_n, self._preset_rad

    def step(self) -> None:
        """One step of time."""
        self._count += 1
        drive_mm = self.drive.speed_mm_per_s * self._count * self._step_s
        self._alpha_n, self._beta = self._convolved.alpha_beta(self._step_s)
        self._way_mm = self._probe_mm(drive_mm)
        self.force_n = self._resisting_n(self._way_mm)
        self._convolved_n = self._convolved.advance(self._step_s, self.force_n)

    def _resisting_n(self, way_mm: Floats) -> Floats:
        """Force at a way of the probe, at the end of the step."""
        elastic_n = (self._per_mm * np.maximum(way_mm, _LEAST_MM)) ** self._power
        return np.asarray((elastic_n - self._alpha_n) / self._beta)

    def _probe_mm(self, drive_mm: float) -> Floats:
        """Where springs and contact are in balance, by secants."""
        if self.drive.springs is None:
            return np.full(self.force_n.shape, drive_mm)
        self._set_presets()
        angle_rad = self._start_rad + drive_mm / self._mm_per_rad

        def missing_nm(way_mm: Floats) -> Floats:
            pull_nm = self._pull_nm(angle_rad - way_mm / self._mm_per_rad)
            return pull_nm - self.drive.friction_nm - self._resisting_n(way_mm) * self._mm_per_rad / 1000

        # from where an even motion would have it, and from a little before
        way_mm, before_mm = self._way_mm + self._last_mm, self._way_mm + 0.9 * self._last_mm
        before_nm = missing_nm(before_mm)
        for _ in range(_NEWTON):
            now_nm = missing_nm(way_mm)
            rise = now_nm - before_nm
            change_mm = np.where(rise == 0, 0.0, -now_nm * (way_mm - before_mm) / np.where(rise == 0, 1.0, rise))
            before_mm, before_nm, way_mm = way_mm, now_nm, way_mm + change_mm
            if np.abs(change_mm).max() < _SOLVED_MM:
                break
        self._last_mm = way_mm - self._way_mm
        return np.asarray(way_mm)

    def _pull_nm(self, ahead_rad: Floats) -> Floats:
        """Torque of the springs on the shaft, with the middle of the motors so far ahead of it."""
        springs = self.drive.springs
        assert springs is not None
        first, second = ahead_rad + self._preset_rad, ahead_rad - self._preset_rad
        return np.asarray(
            springs.k1_nm * np.sinh(springs.a1_per_rad * first) + springs.k2_nm * np.sinh(springs.a2_per_rad * second)
        )

    def _balanced_rad(self) -> Floats:
        """How far ahead the middle of the motors is when the probe comes to the surface: against friction alone."""
        springs = self.drive.springs
        if springs is None:
            return self._preset_rad
        ahead = np.zeros(self.force_n.shape)
        for _ in range(_NEWTON):
            stiffness = stiffness_at(-ahead, self._preset_rad, springs)
            ahead = ahead - (self._pull_nm(ahead) - self.drive.friction_nm) / stiffness
        return ahead

    def _set_presets(self) -> None:
        """Commands of the force so far, and what the motors have made of older ones."""
        commanded = self._commanded[-1]
        if (stepped := np.flatnonzero(self.force_n >= self._next_n)).size:
            commanded = commanded.copy()
            for p in stepped.tolist():
                force_n = float(self.force_n[p])
                commanded[p], self._next_n[p] = self._steps[p].preset_rad(force_n), self._steps[p].next_n(force_n)
        self._commanded.append(commanded)
        late = round(self.drive.preset_latency_s / self._step_s)
        wanted = self._commanded[max(0, len(self._commanded) - 1 - late)]
        most = self.drive.motor_rad_per_s * self._step_s
        self._preset_rad = self._preset_rad + np.clip(wanted - self._preset_rad, -most, most)
