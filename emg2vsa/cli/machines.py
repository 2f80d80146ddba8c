"""Options of ``emg2vsa run`` for more than one machine."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from emg2vsa.cli.arguments import jobs_of

if TYPE_CHECKING:
    from emg2vsa.pipeline.cluster import ClusterWorkers
    from emg2vsa.study import Study

_TIMEOUT_S = 60.0
_ADDRESS = re.compile(r"((tcp|tls|ws|wss)://)?([\w.-]+|\[[\da-fA-F:]+\]):\d{1,5}")


def add_machines(parser: argparse.ArgumentParser) -> None:
    """A scheduler, or a cluster of this computer."""
    group = parser.add_argument_group("more than one machine (docs/how-to/many-machines.md)")
    one = group.add_mutually_exclusive_group()
    one.add_argument(
        "--scheduler",
        type=_address,
        metavar="ADDRESS",
        help="let the workers of this Dask scheduler carry out the steps of recordings and runs, for example "
        "tcp://10.0.0.1:8786",
    )
    one.add_argument(
        "--cluster",
        type=_local,
        metavar="local[:N]",
        help="the same with N Dask workers that are started on this computer (default: --jobs, else all cores)",
    )
    group.add_argument(
        "--timeout",
        type=_seconds,
        metavar="S",
        help=f"longest time to wait for the scheduler, and for a worker where there is none (default {_TIMEOUT_S:g} s)",
    )


def cluster_of(
    arguments: argparse.Namespace, study: Study, stages: Sequence[str], say: Callable[[str], None]
) -> ClusterWorkers | None:
    """The cluster that was asked for; None for processes of this computer."""
    if arguments.scheduler is None and arguments.cluster is None:
        return None
    from emg2vsa.pipeline.cluster import ClusterWorkers

    return ClusterWorkers(
        study,
        stages,
        address=arguments.scheduler or "",
        local=0 if arguments.cluster is None else arguments.cluster or jobs_of(arguments),
        timeout_s=_TIMEOUT_S if arguments.timeout is None else arguments.timeout,
        say=say,
    )


def _address(text: str) -> str:
    if not _ADDRESS.fullmatch(text):
        raise argparse.ArgumentTypeError(f"expected an address such as tcp://10.0.0.1:8786, but found {text!r}")
    return text


def _local(text: str) -> int:
    """Number of workers; 0 where none is given."""
    found = re.fullmatch(r"local(:[1-9]\d{0,3})?", text)
    if not found:
        raise argparse.ArgumentTypeError(f"expected local or local:N with N from 1, but found {text!r}")
    return int((found[1] or ":0")[1:])


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not 0 < seconds < 1e6:
        raise argparse.ArgumentTypeError(f"expected a number of seconds above 0, but found {text!r}")
    return seconds
