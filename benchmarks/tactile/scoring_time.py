"""What a user waits for: a press on disk to its score, in a warm process, as a command, and the first time ever."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.tactile.table import Cell, Table
from benchmarks.tactile.timing import Run, best_times, one_thread
from casr.flow.estimate import ENGINES, FlowSettings
from casr.frame_files import open_frames
from casr.scoring import ScoreSettings, score
from casr.synthetic.press import simulate_press
from casr.synthetic.settings import PressSettings, TimelineSettings
from casr.synthetic.write import write_press

SECOND_PRESS = PressSettings(timeline=TimelineSettings(loading_s=2.4))
"A press of about 60 frames at 20 Hz."


def scoring_time_table(n_commands: int = 3) -> Table:
    """Processor time from a multi-page TIFF with force log to a score, by engine."""
    with tempfile.TemporaryDirectory() as folder:
        press = write_press(simulate_press(SECOND_PRESS), Path(folder) / "press")
        n_frames = len(open_frames(press))
        with one_thread():
            times = best_times({engine: _warm(press, engine) for engine in ENGINES}, n_repeats=5)
        rows: list[list[Cell]] = []
        for engine in ENGINES:
            fresh = Path(folder) / f"kernels-{engine}"
            first = _command_s(press, engine, fresh)
            later = min(_command_s(press, engine, fresh) for _ in range(n_commands))
            rows.append([engine, times[engine], 1e3 * times[engine] / n_frames, later, first])
    columns = (
        ("engine", ""),
        ("score s", ".3f"),
        ("ms per frame", ".2f"),
        ("command s", ".2f"),
        ("first ever s", ".2f"),
    )
    notes = (
        "score: in a process that has scored before. command: 'casr score', imports and loading of kernels included.",
        "first ever: the same command when no kernel was compiled before.",
    )
    return Table(
        "scoring_time", f"A press of {n_frames} frames on disk to its score, processor time", columns, rows, notes
    )


def _warm(press: Path, engine: str) -> Run:
    settings = ScoreSettings(flow=FlowSettings(engine=engine))
    score(open_frames(press), settings)
    return lambda: score(open_frames(press), settings)


def _command_s(press: Path, engine: str, kernels: Path) -> float:
    """Processor time of one command in a new process, s."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(kernels), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "casr.cli", "score", str(press), "--engine", engine, "--json"]
    before = os.times()
    subprocess.run(command, env=environment, check=True, capture_output=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system
