"""A press as the algorithms see it: frames read one at a time, a force for each frame, and the loading phase."""

from casr.frames.force import FORCE_RULES, force_per_frame
from casr.frames.lag import CameraLag, camera_lag
from casr.frames.loading import LoadingPhase, loading_phase
from casr.frames.readings import ForceReadings, check_newtons, frame_times_by_rows
from casr.frames.sequence import FrameSequence, FrameSource
from casr.frames.spikes import note_on_spikes, spikes
from casr.frames.tare import ForceZero, RestingForce, force_zero, notes_on_zero

__all__ = [
    "FORCE_RULES",
    "CameraLag",
    "ForceReadings",
    "ForceZero",
    "FrameSequence",
    "FrameSource",
    "LoadingPhase",
    "RestingForce",
    "camera_lag",
    "check_newtons",
    "force_per_frame",
    "force_zero",
    "frame_times_by_rows",
    "loading_phase",
    "note_on_spikes",
    "notes_on_zero",
    "spikes",
]
