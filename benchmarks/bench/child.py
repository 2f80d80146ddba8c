"""``python -m benchmarks.bench.child OPTIONS``: one area measured in a process of its own, the result as JSON.

The parent sets the number of threads before this process loads NumPy, and may put another revision of emg2vsa and casr
before this one on the path (``compare``).
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from subprocess import PIPE, Popen
from typing import Any

from benchmarks.bench.measure import one_thread_environment
from benchmarks.bench.results import AreaResult, from_json, to_json
from casr.terminal import finite
from emg2vsa.errors import DataError

SOURCE = Path(__file__).resolve().parents[2]


def measured_in_child(name: str, options: dict[str, Any], product: Path | None = None) -> AreaResult:
    """An area measured by a child process.

    options : those of ``measure.measure`` with ``size`` as text. product : the folder that holds the packages emg2vsa
    and casr to be measured, if not those of this checkout. DataError where the child ends without a result.
    """
    environment = one_thread_environment()
    environment["PYTHONPATH"] = os.pathsep.join(str(folder) for folder in (product, SOURCE) if folder)
    command = [sys.executable, "-P", "-m", "benchmarks.bench.child", json.dumps({"name": name, **options})]
    # complaints and progress of the child go straight to the terminal; -P keeps the working folder off its path
    with Popen(command, stdout=PIPE, text=True, env=environment) as child:
        try:
            text, _ = child.communicate()
        except BaseException:
            child.kill()
            raise
    if child.returncode:
        raise DataError(
            f"area {name}", wanted="a result of the process that measures it", found=f"exit status {child.returncode}",
            do="What it printed above says why.",
        )  # fmt: skip
    return from_json(json.loads(text))


def main() -> None:
    """Measure as the one argument says, in JSON."""
    from benchmarks.areas import area
    from benchmarks.bench.case import Size
    from benchmarks.bench.measure import measure

    options = json.loads(sys.argv[1])
    # libraries under test may print; the standard output holds the result alone
    results, sys.stdout = sys.stdout, sys.stderr
    size = Size(options.pop("size"))
    found = measure(area(options.pop("name")), size, **options, say=lambda text: print(text, file=sys.stderr))
    json.dump(finite(to_json(found)), results)
    results.flush()


if __name__ == "__main__":
    main()
