"""Every claim on data, judged again along other paths of analysis: how much a verdict hangs on choices.

A path differs from the study's own in one choice, or in several at once. Its intervals have the study's confidence.
Steegen, Tuerlinckx, Gelman and Vanpaemel (2016), Perspectives on Psychological Science 11, 702.
"""

from emg2vsa.multiverse.index import IndexPresets, index_presets
from emg2vsa.multiverse.paths import KINDS, Paths, all_paths

__all__ = ["KINDS", "IndexPresets", "Paths", "all_paths", "index_presets"]
