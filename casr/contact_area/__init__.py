"""Area of the first contact, A_c0, from the pins of the frames before and at contact (paper, section IV.A)."""

from casr.contact_area.rules import AS_PRINTED, RULES, FirstContact, InitialArea, area_of, initial_area

__all__ = ["AS_PRINTED", "RULES", "FirstContact", "InitialArea", "area_of", "initial_area"]
