"""Trials by hand: presses with constant envelopes."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.signals.delay_budget import DelayBudget
from emg2vsa.trials import Trials


