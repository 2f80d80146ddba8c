"""The reference of the session's files names everything that is written."""

from __future__ import annotations

import re
from pathlib import Path

from emg2vsa.session.dataset import WRITTEN_FILE
from emg2vsa.session.dataset_events import EVENT_COLUMNS
from emg2vsa.session.journal import JOURNAL_FILE, KINDS
from emg2vsa.session.plan import PLAN_FILE
from emg2vsa.session.record import LOCK_FILE

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "session-files.md"


def test_the_page_names_every_file_every_kind_of_event_and_every_column():
    named = set(re.findall(r"`([^`]+)`", PAGE.read_text(encoding="utf-8")))
    assert named >= {*KINDS, *EVENT_COLUMNS, PLAN_FILE, JOURNAL_FILE, WRITTEN_FILE, LOCK_FILE}
