"""Tasks on the workers of a Dask cluster, with the interface of ``pool.Workers``.

A task is one recording or one run. Steps of the whole study run in the calling process. A worker is asked what its
results depend on, before it carries out a task. Dask is loaded when a cluster is asked for.
"""

from __future__ import annotations

import contextlib
import importlib
import logging
import os
import platform
import queue
import secrets
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import casr
import emg2vsa
from casr.blas_kernel import blas_kernel
from casr.one_thread import VARIABLES
from emg2vsa.errors import DataError, SettingError, install_extra
from emg2vsa.pipeline.code import Code
from emg2vsa.pipeline.fingerprint import digest, state_of
from emg2vsa.pipeline.places import is_writable
from emg2vsa.pipeline.plan import memory_of_files
from emg2vsa.pipeline.stage_order import module_of, stage
from emg2vsa.pipeline.tasks import Ended, OnEnd, Task
from emg2vsa.study import Study

_LOOK_S = 1.0
"""So often the cluster is looked at while no task ends."""
_END_S = 3.0
"""So long a scheduler may take to answer while the run ends: one that does not answer is left."""
_AHEAD = 3
"""Tasks handed over per worker, so that none waits for work, and the scheduler holds few."""
_SHOWN = 3
"""Workers that differ, and differences of each, that are named."""
MARK = "mark of this run in the study's folder"
"""Among the facts: what the worker reads in a file that the run made there."""
AT_A_TIME = "tasks at a time"
_begun: list[str] = []


class ClusterWorkers:
    """The workers of a Dask scheduler, or of a cluster of processes on this computer.

    Parameters
    ----------
    study, stages : what is to run; every worker has to see the study's folder and to have the same code and libraries.
    address : of a running scheduler. local : or the number of processes to start here. timeout_s : how long to wait for
    the scheduler, and for a worker where there is none. say : is told what is waited for.

    Entering raises SettingError where the extra is not installed, and DataError where the scheduler does not answer,
    has no workers, or a worker differs. So does ``run`` when the scheduler or the last worker is lost.
    """

    def __init__(
        self,
        study: Study,
        stages: Sequence[str],
        *,
        address: str = "",
        local: int = 0,
        timeout_s: float = 60.0,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._study, self._stages, self._timeout_s, self._say = study, stages, timeout_s, say
        self._address, self._local = address, local
        self._mark = study.results / "under-way" / f"cluster-{secrets.token_hex(8)}"
        self._held = contextlib.ExitStack()
        self._client: Any = None
        self._asked = Asked(self._mark, ())
        self._facts: dict[str, str] = {}
        self._running: dict[Any, tuple[Task, dict[str, tuple[int, int] | None]]] = {}
        self._most = 1

    def __enter__(self) -> Self:
        with contextlib.ExitStack() as held:
            self._open(held)
            self._check_workers()
            self._held = held.pop_all()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        with self._held, contextlib.suppress(OSError):  # the scheduler may be what was lost
            if self._running and self._client.status == "running":
                self._give_up()

    def run(self, tasks: Sequence[Task], on_end: OnEnd, *, alone: int = 1, load: Sequence[str] = ()) -> None:
        """Run all tasks, and report each as it ends; ``alone`` and ``load`` are the pool's concern.

        DataError : the scheduler was lost, or all workers were, or one differs.
        """
        here = [task for task in tasks if stage(task.step.partition("/")[0]).per == "study"]
        for task in here:
            on_end(task())
        away = tasks if not here else [task for task in tasks if task not in here]
        for task in self._side_by_side(away, on_end):
            # workers died with it, perhaps by another task: one at a time, so that the task that kills them is known
            if self._side_by_side([task], on_end):
                task.claim.unlink(missing_ok=True)
                died = "every worker that tried it died (out of memory, or killed). Give workers more memory."
                on_end(Ended(task.step, "failed", died))

    def _side_by_side(self, tasks: Sequence[Task], on_end: OnEnd) -> list[Task]:
        """The tasks that were not done because the workers that tried them died."""
        distributed: Any = importlib.import_module("distributed")
        waiting, ended, died = deque(tasks), queue.SimpleQueue[Any](), []
        alive = time.monotonic()
        while waiting or self._running:
            while waiting and len(self._running) < self._most:
                task = waiting.popleft()
                paths = [str(path) for files in task.given.files.values() for path in files]
                seen = {path: size_and_time(path) for path in paths}
                key = f"{task.step}-{secrets.token_hex(8)}"
                future = self._client.submit(attempt, task, seen, self._asked, key=key, pure=False)
                self._running[future] = task, seen
                future.add_done_callback(ended.put)
            try:
                future = ended.get(timeout=_LOOK_S)
            except queue.Empty:
                alive = time.monotonic() if self._count_workers() else alive
                if time.monotonic() - alive > self._timeout_s:
                    raise self._lost("that all its workers are gone") from None
                continue
            alive = time.monotonic()
            task, seen = self._running.pop(future)
            try:
                result = self._result(future)
            except DataError:
                raise
            except distributed.KilledWorker:
                died.append(task)
                continue
            except distributed.CancelledError as error:
                raise self._lost("that the connection to it ended") from error
            except Exception as error:  # a task keeps its own errors: this is the worker's
                raise self._lost(f"a worker that cannot carry out a task ({type(error).__name__}: {error})") from error
            if isinstance(result, Refused) and result.unseen and size_and_time(result.unseen) != seen[result.unseen]:
                changed = f"{result.unseen} changed while the step ran. Run the study again."
                result = Ended(task.step, "failed", changed)
            if isinstance(result, Refused):
                raise self._refuse({"a worker that came later": result.facts}, result.unseen)
            on_end(result)
        return died

    def _open(self, held: contextlib.ExitStack) -> None:
        """Connect, wait for workers, and mark the study's folder."""
        dask, distributed = _dask()
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what a user has to know is said here
        held.enter_context(dask.config.set({"distributed.scheduler.allowed-failures": 1}))  # of a local cluster
        if self._local:
            for who in ("scheduler", "worker"):
                held.enter_context(dask.config.set({f"distributed.{who}.http.routes": []}))
            cluster = distributed.LocalCluster(
                n_workers=self._local, threads_per_worker=1, memory_limit=0, silence_logs=logging.CRITICAL,
                host="127.0.0.1", dashboard_address="127.0.0.1:0", scheduler_kwargs={"dashboard": False},
            )  # fmt: skip
            self._address = held.enter_context(cluster).scheduler_address
        self._client = self._connected(distributed)
        held.callback(self._close)
        end = time.monotonic() + self._timeout_s
        while not self._count_workers():
            if time.monotonic() > end:
                raise DataError(
                    self._address, wanted="one worker or more", found=f"none within {self._timeout_s:g} s",
                    do=f"Start some with: dask worker {self._address} --nthreads 1. Or wait longer: --timeout.",
                )  # fmt: skip
            time.sleep(0.1)
        self._mark.parent.mkdir(parents=True, exist_ok=True)
        held.callback(self._mark.unlink, missing_ok=True)
        self._mark.write_text(self._mark.name)

    def _connected(self, distributed: Any) -> Any:
        """A client of the scheduler. DataError where none answers."""
        try:
            return distributed.Client(self._address, timeout=self._timeout_s, set_as_default=False)
        except TypeError as error:  # what Dask raises where an encrypted address meets no certificates
            raise DataError(
                f"emg2vsa run --scheduler {self._address}", wanted="certificates for an encrypted connection",
                found=f"none ({error})",
                do="Name them under distributed.comm.tls in Dask's configuration, or use an address with tcp://.",
            ) from error  # fmt: skip
        except (OSError, ValueError) as error:
            raise DataError(
                f"emg2vsa run --scheduler {self._address}", wanted="a Dask scheduler that answers",
                found=f"none within {self._timeout_s:g} s ({error})",
                do="Start it with dask scheduler, or give the address that it prints.",
            ) from error  # fmt: skip

    def _check_workers(self) -> None:
        """Ask every worker for what its results depend on. DataError where one differs from this process."""
        prints = memory_of_files(self._study.results, self._say)
        code = Code(prints)
        libraries = {"dask", "distributed"}
        for name in self._stages:
            libraries.update(code.reached(module_of(name)).libraries.value)
        prints.save()
        asked = Asked(self._mark, tuple(sorted(libraries - {"python"})))
        self._facts = facts_here(asked.mark, asked.libraries) | {AT_A_TIME: "1"}
        self._asked = Asked(asked.mark, asked.libraries, digest_of(self._facts))
        try:
            answers = self._client.run(
                facts_of_worker, asked.mark, asked.libraries, on_error="return", callback_timeout=self._timeout_s
            )
        except (OSError, RuntimeError) as error:
            raise self._lost(self._silence(error, "that it or a worker")) from error
        if differ := {worker: facts for worker, facts in answers.items() if facts != self._facts}:
            raise self._refuse(differ)

    def _count_workers(self) -> int:
        """Number of workers; raises DataError where the scheduler is lost. How many tasks go out follows it."""
        try:
            threads = self._client.sync(self._client.scheduler.ncores, callback_timeout=self._timeout_s)
        except Exception as error:
            raise self._lost(self._silence(error, "that it")) from error
        self._most = _AHEAD * max(len(threads), 1)
        return len(threads)

    def _result(self, future: Any) -> Any:
        """The result of a task that ended; a worker slow to send it is waited for while the scheduler answers."""
        while True:
            try:
                return future.result(timeout=self._timeout_s)
            except TimeoutError:
                self._count_workers()

    def _give_up(self) -> None:
        """Cancel what is under way, and wait for what workers have begun: no other run may meet it.

        TimeoutError : the scheduler does not answer.
        """
        self._answers()
        self._client.cancel(list(self._running), force=True)
        self._running.clear()
        if not self._local and self._begun():
            self._say("Waiting for tasks that workers have begun. Ctrl-C again to leave them.")
            while self._begun():
                time.sleep(_LOOK_S)

    def _begun(self) -> bool:
        """Whether a worker is at a task, or too busy to say."""
        try:
            return any(self._client.run(begun, callback_timeout=_END_S).values())
        except TimeoutError:
            self._answers()
            return True

    def _answers(self) -> None:
        """TimeoutError where the scheduler does not answer."""
        self._client.sync(self._client.scheduler.identity, callback_timeout=_END_S)

    def _close(self) -> None:
        with contextlib.suppress(TimeoutError):
            self._client.close(timeout=_END_S)

    def _silence(self, error: Exception, who: str) -> str:
        if isinstance(error, TimeoutError):
            return f"{who} does not answer within {self._timeout_s:g} s"
        return f"{who} does not answer ({type(error).__name__})"

    def _lost(self, found: str) -> DataError:
        do = "See that scheduler and workers run, then give the same command again: what was finished is kept."
        return DataError(self._address, wanted="a Dask scheduler with workers until the end", found=found, do=do)

    def _refuse(self, workers: dict[str, Any], unseen: str = "") -> DataError:
        """The error that names workers and what differs there."""
        told = [f"{one} with {self._differences(facts, unseen)}" for one, facts in list(workers.items())[:_SHOWN]]
        more = f"; and {len(workers) - _SHOWN} more workers" if len(workers) > _SHOWN else ""
        return DataError(
            self._address, wanted="workers with the same program, libraries, threads and files as here",
            found="; ".join(told) + more,
            do="Start workers from the same installation, with one thread each, on computers that share the study's "
            "folder: dask worker ADDRESS --nthreads 1. Where processors differ, set OPENBLAS_CORETYPE to one kernel of "
            "all, such as Haswell, here and for every worker.",
        )  # fmt: skip

    def _differences(self, facts: Any, unseen: str) -> str:
        """What differs at a worker, in words. facts : the worker's, or the error that it met when asked."""
        if isinstance(facts, BaseException):
            return f"a program that does not know the question ({type(facts).__name__}: {facts})"
        names = [*self._facts, *(name for name in facts if name not in self._facts)]
        pairs = [(name, facts.get(name, "absent"), self._facts.get(name, "absent")) for name in names]
        what = [f"{name} {there} (here {here})" for name, there, here in pairs if there != here]
        more = f" and {len(what) - _SHOWN} more" if len(what) > _SHOWN else ""
        return (", ".join(what[:_SHOWN]) or f"another file {unseen}") + more


@dataclass(frozen=True)
class Asked:
    """mark : a file of the running study. libraries : whose versions count. wanted : digest of the facts."""

    mark: Path
    libraries: tuple[str, ...]
    wanted: str = ""


@dataclass(frozen=True)
class Refused:
    """A worker that would compute something else. facts : its own; unseen : a file that it does not see as it is."""

    facts: Mapping[str, str]
    unseen: str = ""


@cache
def facts_here(mark: Path, libraries: tuple[str, ...]) -> dict[str, str]:
    """What the results of this process depend on beside the task: versions, arithmetic, code, the study's folder."""
    found = {"emg2vsa": emg2vsa.__version__, "python": platform.python_version(), "kernel of BLAS": blas_kernel()}
    found |= {name: _version(name) for name in libraries}
    found |= {name: os.environ.get(name, "unset") for name in VARIABLES}
    found[MARK] = _read_mark(mark)
    return found | _code()


def facts_of_worker(mark: Path, libraries: tuple[str, ...], dask_worker: Any = None) -> dict[str, str]:
    """The same of a worker of Dask, which gives itself."""
    return facts_here(mark, libraries) | {AT_A_TIME: str(dask_worker.state.nthreads)}


def attempt(task: Task, files: Mapping[str, tuple[int, int] | None], asked: Asked) -> Ended | Refused:
    """Carry out a task, unless this worker would compute something else.

    files : size and time of modification (ns) of the files that the task reads. The claim of an earlier attempt goes:
    the scheduler tries a task again only when it has given up the worker before.
    """
    worker = importlib.import_module("distributed").get_worker()
    facts = facts_of_worker(asked.mark, asked.libraries, worker)
    if digest_of(facts) != asked.wanted:
        return Refused(facts)
    for path, state in files.items():
        if size_and_time(path) != state:
            return Refused(facts, path)
    task.claim.unlink(missing_ok=True)
    _begun.append(task.step)
    try:
        return task()
    finally:
        _begun.remove(task.step)


def begun() -> list[str]:
    """Steps that this worker is at."""
    return list(_begun)


def size_and_time(path: str | Path) -> tuple[int, int] | None:
    """What two computers agree on of a file that both see; None where there is none."""
    found = state_of(path)
    return None if found is None else found[:2]


def digest_of(facts: Mapping[str, str]) -> str:
    """One digest of all facts."""
    return digest(repr(sorted(facts.items())))


@cache
def _code() -> dict[str, str]:
    """Digests as of the first question: a worker that runs old code does not become new when files change."""
    packages = (Path(str(package.__file__)).parent for package in (emg2vsa, casr))
    files = ((folder.parent, path) for folder in packages for path in sorted(folder.rglob("*.py")))
    return {f"code of {path.relative_to(base).as_posix()}": digest(path.read_bytes()) for base, path in files}


@cache
def _version(distribution: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(distribution)
    except PackageNotFoundError:
        return "absent"


def _read_mark(mark: Path) -> str:
    """Text of the file, if files can be written beside it too; else the reason why not."""
    try:
        held = mark.read_text()
    except OSError as error:
        return f"unreadable ({error.strerror or error})"
    return held if is_writable(mark.parent) else "in a folder that cannot be written to"


def _dask() -> tuple[Any, Any]:
    """The packages ``dask`` and ``distributed``. SettingError where they are not installed."""
    try:
        return importlib.import_module("dask"), importlib.import_module("distributed")
    except ModuleNotFoundError as error:
        raise SettingError(
            "emg2vsa run", wanted="the extra for clusters", found=f"no {error.name}",
            do=f"Install it: {install_extra('cluster')}.",
        ) from error  # fmt: skip
