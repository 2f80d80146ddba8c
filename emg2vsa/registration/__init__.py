"""A registered analysis: what a study plans, frozen in a file before its data, and how it differs from that now."""

from emg2vsa.registration.deviations import Deviation, Registered, compared
from emg2vsa.registration.document import document, read_registration, write_registration
from emg2vsa.registration.plan import plan_of, planned_claims

__all__ = [
    "Deviation", "Registered", "compared", "document", "plan_of", "planned_claims", "read_registration",
    "write_registration",
]  # fmt: skip
