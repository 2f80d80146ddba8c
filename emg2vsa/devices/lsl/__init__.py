"""A stream of the Lab Streaming Layer."""
