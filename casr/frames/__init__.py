"""A press as the algorithms see it: frames read one at a time, a force for each frame, and the loading phase."""

from casr.frames.force import FORCE_RULES, force_per_frame
from casr.frames.loading import LoadingPhase, loading_phase
from casr.frames.sequence import FrameSequence, FrameSource

__all__ = [
    "FORCE_RULES",
    "FrameSequence",
    "FrameSource",
    "LoadingPhase",
    "force_per_frame",
    "loading_phase",
]
