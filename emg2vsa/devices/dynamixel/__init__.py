"""ROBOTIS Dynamixel X-series motors with current sensing, as a joint whose stiffness is a position gain."""
