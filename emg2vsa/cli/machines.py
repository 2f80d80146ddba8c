"""Options of ``emg2vsa run`` for more than one machine."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from casr.command_line import add_options
from emg2vsa.cli.arguments import jobs_of

if TYPE_CHECKING:
    from emg2vsa.pipeline.cluster import ClusterWorkers
    from emg2vsa.pipeline.shard import Shard
    from emg2vsa.study import Study

_TIMEOUT_S = 60.0
_ADDRESS = re.compile(r"((tcp|tls|ws|wss)://)?([\w.-]+|\[[\da-fA-F:]+\]):\d{1,5}")
_ONE_OF = """
--scheduler ADDRESS  let the workers of this Dask scheduler carry out the steps of recordings and runs, for example
  tcp://10.0.0.1:8786
--cluster LOCAL  the same with N Dask workers that are started on this computer (default: --jobs, else all cores)
--shard I/N  run the steps of recordings and runs that belong to share I of N, while other processes run the other
  shares; steps of the whole study wait for a run without --shard
"""
_TIMEOUT = f"""
--timeout S  longest time to wait for the scheduler, and for a worker where there is none (default {_TIMEOUT_S:g} s)
"""


def add_machines(parser: argparse.ArgumentParser) -> None:
    """A scheduler, a cluster of this computer, or one share of several."""
    group = parser.add_argument_group("more than one machine (docs/how-to/many-machines.md)")
    types = {"ADDRESS": _address, "LOCAL": _local, "I/N": _shard, "S": _seconds}
    add_options(group.add_mutually_exclusive_group(), _ONE_OF, types, cluster={"metavar": "local[:N]"})
    add_options(group, _TIMEOUT, types)


def cluster_of(
    arguments: argparse.Namespace, study: Study, stages: Sequence[str], say: Callable[[str], None]
) -> ClusterWorkers | None:
    """The cluster that was asked for; None for processes of this computer. SettingError : options that do not go
    together."""
    from emg2vsa.errors import SettingError

    if arguments.jobs and arguments.scheduler:
        do = "Leave --jobs out."
        raise SettingError("emg2vsa run --scheduler", wanted="workers of the scheduler alone", found="--jobs", do=do)
    if arguments.scheduler is None and arguments.cluster is None:
        if arguments.timeout is not None:
            do = "Leave --timeout out."
            raise SettingError("emg2vsa run --timeout", wanted="--scheduler or --cluster", found="neither", do=do)
        return None
    from emg2vsa.pipeline.cluster import ClusterWorkers

    local = 0 if arguments.cluster is None else arguments.cluster or jobs_of(arguments)
    timeout_s = _TIMEOUT_S if arguments.timeout is None else arguments.timeout
    return ClusterWorkers(study, stages, address=arguments.scheduler or "", local=local, timeout_s=timeout_s, say=say)


def _shard(text: str) -> Shard:
    from emg2vsa.pipeline.shard import Shard

    found = re.fullmatch(r"([1-9]\d{0,5})/([1-9]\d{0,5})", text)
    if not found or int(found[1]) > int(found[2]):
        raise argparse.ArgumentTypeError(f"expected I/N with I from 1 to N, such as 3/16, but found {text!r}")
    return Shard(int(found[1]), int(found[2]))


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
