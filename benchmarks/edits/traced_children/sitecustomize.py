"""Found by child processes whose PYTHONPATH has this folder: they record what they execute, as ``trace_step`` does."""

import importlib.util
import os
import sys
from pathlib import Path

if "TRACE_TO" in os.environ and (sys.argv[0:1] != ["-c"] or "casr.child_process" in sys.orig_argv[-1]):
    spec = importlib.util.spec_from_file_location("trace_step", Path(__file__).parent.parent / "trace_step.py")
    assert spec is not None
    assert spec.loader is not None
    trace_step = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(trace_step)
    trace_step.record(Path(os.environ["TRACE_TO"]))
