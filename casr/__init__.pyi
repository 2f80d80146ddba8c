from casr.errors import CasrError as CasrError
from casr.frame_files import find_presses as find_presses
from casr.frame_files import open_frames as open_frames
from casr.frame_files import read_camera as read_camera
from casr.press_tables import frame_table as frame_table
from casr.public import score as score
from casr.scored import Score as Score
from casr.scored import ScoreSettings as ScoreSettings
from casr.stream import StreamScorer as StreamScorer
from emg2vsa.worlds.tactile import simulate_press as simulate_press

__version__: str

__all__ = [
    "CasrError",
    "Score",
    "ScoreSettings",
    "StreamScorer",
    "__version__",
    "find_presses",
    "frame_table",
    "open_frames",
    "read_camera",
    "score",
    "simulate_press",
]
