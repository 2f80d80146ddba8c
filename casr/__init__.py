"""From tactile frames and force to the contact area spread rate (CASR) of a soft specimen."""

__version__ = "0.2.0"
