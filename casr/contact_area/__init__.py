"""Area of the first contact, A_c0, from the pins of the frames before and at contact (paper, section IV.A)."""

from casr.contact_area.algorithm_1 import AS_PRINTED
from casr.contact_area.initial_area import InitialArea
from casr.contact_area.rules import RULES, initial_area

__all__ = ["AS_PRINTED", "RULES", "InitialArea", "initial_area"]
