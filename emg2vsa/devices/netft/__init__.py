"""ATI's Net F/T box and Ethernet Axia: records over UDP, configuration by its web page."""
