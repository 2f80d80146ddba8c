"""Every fault in every phase of a run on the emulated rig: how it ended and why, when it was safe, what was lost.

Run with ``python -m benchmarks.fault_matrix [FAULT ...] [--phase PHASE ...]``. The tests carry out the same cases.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.rig.fault_case import PHASES, Outcome, run_case
from benchmarks.rig.faults import FAULTS


def main() -> None:
    """Print a line for each case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("faults", nargs="*", metavar="FAULT", help=", ".join(FAULTS))
    parser.add_argument("--phase", nargs="+", choices=PHASES, default=PHASES)
    arguments = parser.parse_args()
    print(
        f"{'fault':<31}{'phase':<12}{'ended':<13}{'cause':<19}{'off after s':>11}{'probe mm':>10}{'peak N':>8}"
        f"{'lost rows, forces, frames':>27}  next run"
    )
    outcomes: list[Outcome] = []
    for name in arguments.faults or FAULTS:
        for phase in arguments.phase:
            with TemporaryDirectory() as folder:
                outcomes.append(run_case(name, phase, Path(folder)))
            print(_line(name, phase, outcomes[-1]), flush=True)
    print(
        f"{len(outcomes)} cases: {sum(_as_wanted(o) for o in outcomes)} ended as wanted, "
        f"{sum(not any(o.lost) for o in outcomes)} lost nothing, "
        f"{sum(o.next_run.how == 'completed' for o in outcomes)} next runs completed"
    )


def _as_wanted(outcome: Outcome) -> bool:
    return (outcome.told["how"], outcome.told["cause"]) == outcome.wanted


def _line(name: str, phase: str, outcome: Outcome) -> str:
    told = outcome.told
    # a run that goes on is not safe later, only over later
    went_on = told["how"] in ("completed", "killed")
    off = "" if went_on else "never" if outcome.safe_s is None else f"{outcome.safe_s:.2f}"
    as_wanted = "" if _as_wanted(outcome) else f"  NOT {' '.join(outcome.wanted)}"
    lost = ", ".join(map(str, outcome.lost))
    return (
        f"{name:<31}{phase:<12}{told['how']:<13}{told['cause']:<19}{off:>11}{outcome.probe_mm:>10.2f}"
        f"{outcome.peak_n:>8.1f}{lost:>27}  {outcome.next_run.how}{as_wanted}"
    )


if __name__ == "__main__":
    main()
