"""A real Dask cluster: the outcome is that of one process, whoever dies meanwhile; what cannot work is said once."""

from __future__ import annotations

import contextlib
import importlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from benchmarks.small_study import small_study
from casr.blas_kernel import blas_kernel
from emg2vsa.cli import main
from emg2vsa.errors import DataError
from emg2vsa.pipeline import cluster
from emg2vsa.pipeline.cluster import Asked, ClusterWorkers, digest_of, facts_here
from emg2vsa.pipeline.lock import holder
from emg2vsa.pipeline.tasks import Ended
from emg2vsa.study_file import load_study
from tests.pipeline.test_pool import DEEDS, soon
from tests.small import simulated

pytest.importorskip("distributed", reason="the extra for clusters is not installed")
PEOPLE = ("trials", "fits", "pages")
"""Names that deeds of tests go under: each is the step of a recording or a participant."""


@pytest.fixture
def scheduler() -> Iterator[Scheduler]:
    """A scheduler without workers, in a process of its own."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with started("scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard") as process:
        yield Scheduler(f"tcp://127.0.0.1:{port}", process)


@dataclass(frozen=True)
class Scheduler:
    address: str
    process: subprocess.Popen[bytes]


@pytest.fixture
def address(scheduler: Scheduler) -> str:
    return scheduler.address


class started:
    """A program of Dask with this project's code; killed at the end."""

    def __init__(self, *arguments: str, **environment: str) -> None:
        path = os.pathsep.join([str(Path(__file__).parents[2]), *filter(None, sys.path)])
        self._arguments, self._environment = arguments, os.environ | {"PYTHONPATH": path} | environment

    def __enter__(self) -> subprocess.Popen[bytes]:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "dask", *self._arguments], env=self._environment, start_new_session=True,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        return self.process

    def __exit__(self, *error: object) -> None:
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()


def worker(address: str, **environment: str) -> started:
    return started("worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny", **PINNED | environment)


PINNED = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@pytest.fixture(autouse=True)
def _pinned(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in PINNED.items():
        monkeypatch.setenv(name, value)


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A study of people, of whom nothing was run."""
    return simulated(tmp_path, small_study(specimens=("S1", "S3"), simulation="seed = 3\nrepetitions = 2\n"))


@pytest.fixture
def deeds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[Any]]:
    """Tasks that do as their names say, on workers too."""
    (tmp_path / "deeds_of_clusters.py").write_text(DEEDS.replace('f"s{i}"', 'f"trials/s{i}"'))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *filter(None, sys.path)]))
    monkeypatch.chdir(tmp_path)
    Path("trials").mkdir()
    monkeypatch.delitem(sys.modules, "deeds_of_clusters", raising=False)
    module = importlib.import_module("deeds_of_clusters")
    return lambda *names: list(module.deeds(names))


def outcome(study: Path) -> dict[str, bytes]:
    """Every stored result and every written file of a study; no locks, which tell of processes."""
    loaded = load_study(study)
    parts = (loaded.results / "store", loaded.reports, study.parent / "runs-virtual")
    files = (path for part in parts for path in part.rglob("*") if path.is_file() and not path.name.startswith("."))
    return {path.relative_to(study.parents[2]).as_posix(): path.read_bytes() for path in files}


@pytest.mark.slow
def test_a_cluster_gives_what_one_process_gives_and_a_task_that_kills_workers_is_one_failure(
    small: Path, deeds: Callable[..., list[Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", str(small), "--only", "fits", "--jobs", "1", "--json"]) == 0
    before = outcome(small)
    assert len(before) == 4 + 4
    shutil.rmtree(small.parent / ".emg2vsa")
    assert main(["run", str(small), "--only", "fits", "--cluster", "local:2", "--json"]) == 0, capsys.readouterr()
    assert outcome(small) == before
    ended: dict[str, Ended] = {}
    with ClusterWorkers(load_study(small), PEOPLE, local=2) as workers:
        workers.run(deeds("ok", "die", "refuse", "crash", "ok"), lambda one: ended.__setitem__(one.step, one))
    assert [ended[f"trials/s{i}"].status for i in range(5)] == ["done", "failed", "failed", "failed", "done"]
    assert [ended[f"trials/s{i}"].final for i in range(5)] == [False, False, True, False, False]
    assert ended["trials/s1"].message.startswith("every worker that tried it died")
    assert str(os.getpid()) not in {ended["trials/s0"].message, ended["trials/s4"].message}
    assert list(Path("claims").iterdir()) == []
    assert list((load_study(small).results / "under-way").iterdir()) == []


@pytest.mark.slow
def test_a_lost_scheduler_is_one_error_and_what_was_done_is_kept(
    small: Path, deeds: Callable[..., list[Any]], scheduler: Scheduler
) -> None:
    ended: list[Ended] = []
    address, tasks = scheduler.address, deeds("sleep")
    with worker(address), ClusterWorkers(load_study(small), PEOPLE, address=address) as workers:
        workers.run(deeds("ok", "ok"), ended.append)
        threading.Timer(1, scheduler.process.kill).start()
        with pytest.raises(DataError) as error:
            workers.run(tasks, ended.append)
    assert [one.status for one in ended] == ["done", "done"]
    assert str(error.value).startswith(
        f"{address}: expected a Dask scheduler with workers until the end, but found that "
    )
    assert str(error.value).endswith("give the same command again: what was finished is kept.")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows cannot stop a process")
@pytest.mark.parametrize("ended_by", ["timeout", "SIGTERM"])
def test_a_scheduler_that_is_stopped_ends_the_run(small: Path, scheduler: Scheduler, ended_by: str) -> None:
    under_way = small.parent / ".emg2vsa" / "small" / "under-way"
    timeout = "4" if ended_by == "timeout" else "1000"
    command = [sys.executable, "-m", "emg2vsa.cli", "run", str(small), "--scheduler", scheduler.address]
    with worker(scheduler.address):
        assert soon(lambda: has_worker(scheduler.address), 120)
        run = subprocess.Popen([*command, "--timeout", timeout], stderr=subprocess.PIPE, text=True)
        assert soon(lambda: bool(list(under_way.glob("trials*.json"))), 200)
        scheduler.process.send_signal(signal.SIGSTOP)
        if ended_by == "SIGTERM":
            time.sleep(3)  # the run asks the scheduler every second
            run.terminate()
        told = run.communicate(timeout=200)[1]
    assert run.returncode == (2 if ended_by == "timeout" else 130), told
    assert "Traceback" not in told
    if ended_by == "timeout":
        assert f"{scheduler.address}: expected a Dask scheduler with workers until the end, but found that it" in told
        assert "does not answer within 4 s" in told
        assert "what was finished is kept" in told
    assert holder(small.parent / ".emg2vsa" / "small") == ""


def has_worker(address: str) -> bool:
    distributed = importlib.import_module("distributed")
    with distributed.Client(address, set_as_default=False) as client:
        return bool(client.nthreads())


def test_an_encrypted_address_without_certificates_is_one_error(
    small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert main(["run", str(small), "--scheduler", "tls://127.0.0.1:9", "--timeout", "1"]) == 2
    told = capsys.readouterr().err
    assert "--scheduler tls://127.0.0.1:9: expected certificates for an encrypted connection, but found none (" in told
    assert "distributed.comm.tls in Dask's configuration" in told


def test_a_recording_replaced_while_it_waits_fails_its_step_alone(
    tmp_path: Path, deeds: Callable[..., list[Any]]
) -> None:
    first, second = deeds("ok", "ok")
    recording = tmp_path / "recording"
    recording.write_text("old")
    first.given.files["emg"] = (recording,)

    class Client:
        """Refuses the task whose file was replaced, as ``attempt`` does, and carries out the others."""

        def submit(self, attempt: object, task: Any, seen: dict[str, Any], *more: object, **options: object) -> Any:
            if not seen:
                return Done(task())
            recording.write_text("a newer one")
            return Done(cluster.Refused({}, str(recording)))

    class Done:
        def __init__(self, result: object) -> None:
            self.value = result

        def add_done_callback(self, call: Callable[[Any], None]) -> None:
            call(self)

        def result(self, timeout: float) -> Any:
            return self.value

    workers = ClusterWorkers(load_study_of(tmp_path), PEOPLE, address="tcp://1.2.3.4:5")
    workers._client = Client()
    ended: list[Ended] = []
    workers.run([first, second], ended.append)
    assert [one.status for one in ended] == ["failed", "done"]
    assert ended[0].message == f"{recording} changed while the step ran. Run the study again."
    assert not ended[0].final


@pytest.mark.slow
def test_a_cluster_here_shows_no_page_and_is_reached_from_here_alone(
    small: Path, recwarn: pytest.WarningsRecorder
) -> None:
    def pages(dask_scheduler: Any = None, dask_worker: Any = None) -> tuple[str, list[str]]:
        server = dask_scheduler or dask_worker  # a function within one goes to a worker by value
        rules = [str(rule.matcher.regex.pattern) for rule in server.http_application.wildcard_router.rules]
        return server.http_server.address, rules

    with socket.socket() as other:
        with contextlib.suppress(OSError):  # taken by another program, which does as well
            other.bind(("127.0.0.1", 8787))
            other.listen()
        with ClusterWorkers(load_study(small), ("trials",), local=1) as workers:
            scheduler = workers._client.run_on_scheduler(pages)
            (worker,) = workers._client.run(pages).values()
    assert scheduler == worker == ("127.0.0.1", [])
    assert [str(one.message) for one in recwarn if "Port" in str(one.message)] == []


@pytest.mark.slow
def test_a_worker_that_would_compute_something_else_is_refused_by_name(
    small: Path, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["run", str(small), "--only", "trials", "--scheduler", address, "--timeout"]
    capsys.readouterr()
    with worker(address, OMP_NUM_THREADS="4"):
        assert main([*command, "60"]) == 2
    told = capsys.readouterr().err
    assert "but found tcp://127.0.0.1:" in told
    assert "with OMP_NUM_THREADS 4 (here 1). Start workers from the same installation" in told
    with worker(address, OPENBLAS_CORETYPE="Nehalem"):
        assert main([*command, "60"]) == 2
    assert f"with kernel of BLAS Nehalem (here {blas_kernel()}). Start workers" in capsys.readouterr().err
    assert not list((small.parent / ".emg2vsa" / "small").rglob("*.result"))


def test_facts_tell_what_differs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mark = tmp_path / "mark"
    mark.write_text("token")
    here = facts_here(mark, ("numpy", "no-such-thing"))
    assert here[cluster.MARK] == "token"
    assert here["no-such-thing"] == "absent"
    assert here["kernel of BLAS"] == blas_kernel()
    assert here["code of emg2vsa/pipeline/run_study.py"]
    assert here["code of casr/atomic.py"]
    assert facts_here(tmp_path / "none", ())[cluster.MARK] == "unreadable (No such file or directory)"
    workers = ClusterWorkers(load_study_of(tmp_path), ("trials",), address="tcp://1.2.3.4:5")
    workers._facts = {"emg2vsa": "0.2.0", "numpy": "2.0", "a": "1", "b": "2"}
    error = workers._refuse({f"w{i}": {"emg2vsa": "0.1.0", "b": "2"} for i in range(5)})
    assert "w0 with emg2vsa 0.1.0 (here 0.2.0), numpy absent (here 2.0), a absent (here 1); w1 with" in str(error)
    assert "w2 with" in str(error)
    assert "; and 2 more workers. Start workers" in str(error)
    error = workers._refuse({"w0": ModuleNotFoundError("No module named 'emg2vsa'")})
    assert "w0 with a program that does not know the question (ModuleNotFoundError: No module named" in str(error)


def load_study_of(folder: Path) -> Any:
    (folder / "study.toml").write_text(small_study())
    return load_study(folder / "study.toml")


def test_a_worker_that_came_later_or_sees_another_file_carries_out_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, deeds: Callable[..., list[Any]]
) -> None:
    class OneThread:
        class state:
            nthreads = 1

    monkeypatch.setattr(importlib.import_module("distributed"), "get_worker", lambda: OneThread)
    mark, file = tmp_path / "mark", tmp_path / "file"
    mark.write_text("token")
    file.write_text("four")
    facts = facts_here(mark, ()) | {cluster.AT_A_TIME: "1"}
    (task,) = deeds("ok")
    task.claim.parent.mkdir()
    task.claim.write_text("of a worker that died")
    size_and_time = cluster.size_and_time(file)
    refused = cluster.attempt(task, {}, Asked(mark, (), "another"))
    assert refused == cluster.Refused(facts)
    asked = Asked(mark, (), digest_of(facts))
    assert cluster.attempt(task, {str(file): (3, 1)}, asked) == cluster.Refused(facts, str(file))
    assert task.claim.exists()
    assert cluster.attempt(task, {str(file): size_and_time}, asked) == Ended(task.step, "done", str(os.getpid()))
    assert not task.claim.exists()


def test_without_an_answer_or_the_extra_nothing_is_run(
    small: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        nobody = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    capsys.readouterr()
    assert main(["run", str(small), "--scheduler", nobody, "--timeout", "0.5"]) == 2
    assert f"--scheduler {nobody}: expected a Dask scheduler that answers, but found none within 0.5 s" in (
        capsys.readouterr().err
    )
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["run", str(small), "--cluster", "local"]) == 2
    assert 'expected the extra for clusters, but found no distributed. Install it: pip install ".[cluster]" in' in (
        capsys.readouterr().err
    )
    assert not list((small.parent / ".emg2vsa" / "small").rglob("*.result"))


@pytest.mark.slow
def test_a_whole_study_on_a_cluster_with_a_worker_killed_is_that_of_one_process(study: Path, address: str) -> None:
    before = outcome(study)
    for part in (study.parent / ".emg2vsa", load_study(study).reports, study.parent / "runs-virtual"):
        shutil.rmtree(part)
    under_way = study.parent / ".emg2vsa" / "small" / "under-way"
    with worker(address) as first, worker(address):
        command = [sys.executable, "-m", "emg2vsa.cli", "run", str(study), "--scheduler", address, "--json", "--paths"]
        run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert soon(lambda: bool(list(under_way.glob("emulation*.json"))), 300)
        time.sleep(0.5)
        first.kill()
        told = run.communicate()
    assert run.returncode == 0, told
    assert outcome(study) == before
