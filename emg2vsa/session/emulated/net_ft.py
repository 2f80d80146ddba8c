"""The emulated participant's force on an emulated ATI box, for a session whose force is that of a rig file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.rig.emulated.rdt_box import BoxSettings, RdtBox
from emg2vsa.session.emulated.muscles import felt_n
from emg2vsa.session.emulated.participant import EmulatedParticipant

TORQUE_NOISE_NM = 1e-4


def force_box(participant: EmulatedParticipant, axis: tuple[float, float, float], rate_hz: float = 1000.0) -> RdtBox:
    """The box under the specimen. axis : direction, in the sensor's axes, in which a pressing finger pushes."""
    direction = np.array(axis) / np.linalg.norm(axis)

    def wrench(time_s: float) -> Sequence[float]:
        force_n = float(felt_n(participant, np.array([time_s]))[0])
        return [*(force_n * direction).tolist(), 0.0, 0.0, 0.0]

    noise = participant.person.force_noise_n, TORQUE_NOISE_NM
    return RdtBox(wrench, BoxSettings(rate_hz=rate_hz, noise=noise, seed=participant.person.seed[0]))
