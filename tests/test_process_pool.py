"""Calls on several processes: in the order of their ends, a death told of its own call, and Ctrl-C without waiting."""

from __future__ import annotations

import operator
import os
import signal
import subprocess
import sys
import time
from functools import partial

import pytest

from emg2vsa.process_pool import ProcessPool, WorkerDied

SLOW_S = 1.0


def test_one_job_makes_no_process_and_loads_nothing_that_makes_them() -> None:
    code = (
        "import os, sys\nfrom emg2vsa.process_pool import ProcessPool\n"
        "with ProcessPool(1) as pool:\n"
        "    assert [(i, of()) for i, of in pool.ended([os.getpid])] == [(0, os.getpid())]\n"
        "assert not {'multiprocessing', 'concurrent.futures'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_results_come_in_the_order_of_their_ends_and_errors_with_their_own_call() -> None:
    calls = [partial(time.sleep, SLOW_S), os.getpid, partial(operator.truediv, 1, 0), os.getpid]
    with ProcessPool(2) as pool:
        list(pool.ended([os.getpid, os.getpid]))  # the start of a process takes its time
        ended = dict(pool.ended(calls))
        assert list(ended) == [1, 2, 3, 0]
        assert os.getpid() != ended[1]()
        with pytest.raises(ZeroDivisionError):
            ended[2]()
        assert list(pool.ended([])) == []


def test_a_death_is_told_of_the_calls_under_way_and_the_others_are_done() -> None:
    die = partial(exec, f"import os, time; time.sleep({SLOW_S}); os._exit(9)")
    calls = [die, partial(time.sleep, 60), *[partial(operator.add, 1, i) for i in range(4)]]
    results: dict[int, object] = {}
    with ProcessPool(2) as pool:
        list(pool.ended([partial(time.sleep, SLOW_S)] * 2))  # the start of a process takes its time
        for i, result in pool.ended(calls):
            try:
                results[i] = result()
            except WorkerDied as error:
                results[i] = str(error)
    died = "its process died (out of memory, or killed)"
    assert results == {0: died, 1: died, 2: 1, 3: 2, 4: 3, 5: 4}


def test_a_worker_that_dies_between_two_calls_is_replaced() -> None:
    with ProcessPool(2) as pool:
        (pid,) = {of() for _, of in pool.ended([os.getpid])}
        os.kill(pid, signal.SIGTERM)
        time.sleep(0.2)
        assert [(i, of()) for i, of in pool.ended([partial(operator.add, 1, 2)])] == [(0, 3)]


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="Windows has no process groups")
def test_ctrl_c_at_a_terminal_reaches_calls_under_way_and_begins_no_other() -> None:
    """It goes to all processes of the terminal; a worker without a call says nothing of it."""
    code = (
        "import signal\nfrom functools import partial\nfrom time import sleep\n"
        "from emg2vsa.process_pool import ProcessPool\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a shell's job in the background ignores it
        "with ProcessPool(2) as pool:\n"
        f"    list(pool.ended([partial(sleep, {SLOW_S})] * 2))\n"  # the start of a process takes its time
        "    for i, _ in pool.ended([partial(print, 'first', flush=True), *[partial(sleep, 40)] * 9]):\n"
        "        print(i, flush=True)\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert process.stdout is not None
    assert {process.stdout.readline() for _ in range(2)} == {"first\n", "0\n"}
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=35)
    assert out == ""
    assert err.count("Traceback") == 1
    assert err.endswith("KeyboardInterrupt\n")
