"""Options of ``emg2vsa run`` for more than one machine."""

from __future__ import annotations

import argparse
import re
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from emg2vsa.cli.arguments import jobs_of

if TYPE_CHECKING:
    from emg2vsa.pipeline.cluster import ClusterWorkers
    from emg2vsa.pipeline.plan import Step, StepPlan
    from emg2vsa.pipeline.shard import Shard
    from emg2vsa.study import Study

_TIMEOUT_S = 60.0
_ADDRESS = re.compile(r"((tcp|tls|ws|wss)://)?([\w.-]+|\[[\da-fA-F:]+\]):\d{1,5}")


def add_machines(parser: argparse.ArgumentParser) -> None:
    """A scheduler, a cluster of this computer, or one share of several."""
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
    one.add_argument(
        "--shard",
        type=_shard,
        metavar="I/N",
        help="run the steps of recordings and runs that belong to share I of N, while other processes run the other "
        "shares; steps of the whole study wait for a run without --shard",
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

    return ClusterWorkers(
        study,
        stages,
        address=arguments.scheduler or "",
        local=0 if arguments.cluster is None else arguments.cluster or jobs_of(arguments),
        timeout_s=_TIMEOUT_S if arguments.timeout is None else arguments.timeout,
        say=say,
    )


@contextmanager
def ended_by_scheduler() -> Iterator[None]:
    """Let SIGTERM, by which job schedulers end a job, end a run as Ctrl-C does: with its locks given back."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def left_of(plan: StepPlan) -> list[Step]:
    """Steps of a shard that did not run, as a step of the whole study that they need is not done."""
    return [step for step in plan.steps.values() if step.item != "study" and step.status in ("stale", "waits")]


def missing_for(plan: StepPlan, left: Sequence[Step]) -> list[str]:
    """Stages of the whole study that these steps need and that are not done."""
    from emg2vsa.pipeline.plan import DONE
    from emg2vsa.pipeline.stage_order import ORDER, stage

    needs = {need for step in left for need in stage(step.stage).needs if stage(need).per == "study"}
    return [name for name in ORDER if name in needs and plan.steps[f"{name}/study"].status not in DONE]


def rest_in_words(plan: StepPlan) -> str:
    """What a shard left, and what to do when all shards have ended."""
    left = left_of(plan)
    run = f"emg2vsa run {plan.study.path}"
    if not left:
        return f"This shard is done. When all shards are: {run}"
    counts = ", ".join(f"{name} {count}" for name, count in Counter(step.stage for step in left).items())
    missing = missing_for(plan, left)
    if not missing:
        return f"Not run: {counts}. Run this shard again."
    then = f"When all shards have ended: {run} --only {missing[-1]}, then the shards again."
    return f"Not run: {counts}. They need {missing[-1]}. {then}"


def to_try_again(plan: StepPlan) -> bool:
    """Whether a step of the shard failed by something else than its input, such as a full disk."""
    failed = (plan.ledger.last(step.id) for step in plan.steps.values() if step.status == "failed")
    return any(entry is None or not entry.final for entry in failed)


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
