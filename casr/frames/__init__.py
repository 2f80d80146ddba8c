"""A press as the algorithms see it: frames read one at a time, a force for each frame, and the loading phase."""

from casr.frames.force import FORCE_RULES, force_per_frame
from casr.frames.lag import CameraLag, camera_lag
from casr.frames.loading import ForceZero, LoadingPhase, RestingForce, force_zero, loading_phase, notes_on_zero
from casr.frames.readings import (
    ForceReadings,
    TravelReadings,
    check_newtons,
    frame_times_by_rows,
    note_on_spikes,
    spikes,
    travel_per_newton,
)
from casr.frames.sequence import FrameSequence, FrameSource

__all__ = [
    "FORCE_RULES", "CameraLag", "ForceReadings", "ForceZero", "FrameSequence", "FrameSource", "LoadingPhase",
    "RestingForce", "TravelReadings", "camera_lag", "check_newtons", "force_per_frame", "force_zero",
    "frame_times_by_rows", "loading_phase", "note_on_spikes", "notes_on_zero", "spikes", "travel_per_newton",
]  # fmt: skip
