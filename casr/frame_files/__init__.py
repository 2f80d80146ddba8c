"""Presses on disk: frames of every known format, force log and camera file. Frames are decoded when asked for."""

from casr.frame_files.camera_file import read_camera, write_camera
from casr.frame_files.folder import find_presses
from casr.frame_files.force_log import ForceLog, read_force_log
from casr.frame_files.press import open_frames

__all__ = ["ForceLog", "find_presses", "open_frames", "read_camera", "read_force_log", "write_camera"]
