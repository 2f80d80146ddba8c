"""A ROBOTIS Dynamixel of the X series, to the byte: the far end of its serial bus."""
