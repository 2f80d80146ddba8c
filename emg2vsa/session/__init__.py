"""One participant's session: acquired, judged and saved while it runs.

In Python::

    from emg2vsa import session
    from emg2vsa.study_file import load_study

    study = load_study("study.toml")
    done = session.run(study, "P03", virtual=session.Virtual(seed=1, mistakes=("dips@12",)))
    done.how, done.judged.verdict               # how it ended, and how good its recordings are

Data flow: the sources of ``open_session`` hand over blocks of samples on one clock; ``session`` (its turn, 200 a
second) appends them to ``raw_files``, moves on from command to command, and judges each press. Everything that happens
is a line of the ``journal``; ``state`` is a fold over these lines, ``legal`` the table of what it allows and what pages
show of it. ``dataset`` turns a folder of raw files and its journal into BIDS-EMG.
"""

from __future__ import annotations

from casr.lazy_names import lazy_names

_NAMES = {
    "Addresses": ".lab.session_run",
    "Emulation": ".lab.session_devices",
    "FinishedSession": ".lab.session_finish",
    "ReplayedPress": ".lab.session_replay",
    "ReplayedSession": ".lab.session_replay",
    "Pages": ".lab.session_run",
    "SessionEnd": ".lab.session_run",
    "Virtual": ".lab.session_devices",
    "emulate": ".lab.session_devices",
    "finish": ".lab.session_finish",
    "replay": ".lab.session_replay",
    "resume": ".lab.session_run",
    "run": ".lab.session_run",
}
"""Public name to its module, loaded when it is first asked for: this package stands below those modules."""
__all__ = list(_NAMES)

__getattr__, __dir__ = lazy_names(__name__, _NAMES)
