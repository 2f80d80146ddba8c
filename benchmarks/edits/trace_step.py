"""Run steps of a finished study again, and tell which modules ran, what they imported, and the bytes that came out.

``python trace_step.py STUDY OUT STAGE/ITEM ...`` writes to OUT/STAGE: executed.txt, our modules of which
anything ran, be it only their import; called.txt, those of which a function ran; imported.txt, foreign packages;
loaded.txt, what was told of as loaded by name; and product.result.
Each step has a process of its own, forked from one that holds foreign packages, to import them once, but no module of
ours that a step runs. Its child processes do the same recording through ``traced_children/sitecustomize.py``.
"""

from __future__ import annotations

import builtins
import importlib
import importlib.util
import inspect
import os
import sys
import threading
import traceback
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Any

PACKAGES = ("emg2vsa", "casr")
FOREIGN = ("scipy.signal", "scipy.stats", "pandas", "cv2", "tifffile", "jinja2", "matplotlib.backends.backend_svg")


def record(out: Path) -> Callable[[], None]:
    """Begin to write down executed modules and imports of foreign packages; call the result to stop."""
    roots = {package: str(Path(_origin(package)).parent) for package in PACKAGES}
    ran: set[tuple[str, bool]] = set()
    executed, called, imported = ((out / f"{name}.txt").open("a") for name in ("executed", "called", "imported"))
    known: set[str] = set()

    def module_of(file: str) -> str:
        for package, root in roots.items():
            if file.startswith(root + "/"):
                name = ".".join([package, *Path(file).relative_to(root).with_suffix("").parts])
                return name.removesuffix(".__init__")
        return ""

    def on_call(frame: FrameType, event: str, argument: object) -> None:
        file, function = frame.f_code.co_filename, bool(frame.f_code.co_flags & inspect.CO_OPTIMIZED)
        if (file, function) not in ran:
            ran.add((file, function))
            if name := module_of(file):
                for where in (executed, called) if function else (executed,):
                    where.write(name + "\n")
                    where.flush()

    def told(importer: str, name: str) -> None:
        first = name.partition(".")[0]
        if importer.startswith(PACKAGES) and first not in sys.stdlib_module_names and first not in (*PACKAGES, *known):
            known.add(first)
            imported.write(first + "\n")
            imported.flush()

    plain_import, plain_by_name = builtins.__import__, importlib.import_module

    def watched(name: str, globals: Any = None, locals: Any = None, fromlist: Any = (), level: int = 0) -> Any:
        if not level:
            told((globals or {}).get("__name__", ""), name)
        return plain_import(name, globals, locals, fromlist, level)

    def watched_by_name(name: str, package: str | None = None) -> Any:
        told(sys._getframe(1).f_globals.get("__name__", ""), name)
        return plain_by_name(name, package)

    def stop() -> None:
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]
        builtins.__import__, importlib.import_module = plain_import, plain_by_name

    builtins.__import__, importlib.import_module = watched, watched_by_name
    threading.settrace(on_call)
    sys.settrace(on_call)
    return stop


def _origin(package: str) -> str:
    spec = importlib.util.find_spec(package)
    assert spec is not None
    assert spec.origin is not None
    return spec.origin


def main() -> int:
    study, out, steps = sys.argv[1], Path(sys.argv[2]), sys.argv[3:]
    from emg2vsa.pipeline.plan import survey
    from emg2vsa.pipeline.stage_order import ORDER
    from emg2vsa.study_file import load_study

    plan = survey(load_study(study), ORDER, print)
    sys.path.insert(0, str(Path(__file__).parent / "traced_children"))  # which decoders of files search too
    os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)
    for name in FOREIGN:
        importlib.import_module(name)
    for name in steps:
        step = plan.steps[name]
        assert step.status == "fresh", (name, step.status, step.reasons, step.message)
        process = os.fork()
        if not process:
            status = 1
            try:
                run(plan, step, out / step.stage)
                status = 0
            except Exception:
                traceback.print_exc()
            finally:
                sys.stderr.flush()
                os._exit(status)
        if os.waitpid(process, 0)[1]:
            return 1
    return 0


def run(plan: Any, step: Any, out: Path) -> None:
    from casr.by_name import noting
    from emg2vsa import artifacts
    from emg2vsa.pipeline.stage_order import stage
    from emg2vsa.pipeline.store import written_files

    out.mkdir()
    given = plan.given(step)
    if given.folder is not None:
        given = replace(given, folder=out / "folder")
        (out / "folder").mkdir()
    os.environ["TRACE_TO"] = str(out)
    run = stage(step.stage).run
    stop = record(out)
    try:
        with noting() as told:
            product = run(given)
        if given.folder is None:
            artifacts.save(out / "product.result", product)
    finally:
        stop()
    (out / "loaded.txt").write_text("\n".join(sorted(told)))
    if given.folder is not None:
        artifacts.save(out / "product.result", written_files(given.folder, product))


if __name__ == "__main__":
    sys.exit(main())
