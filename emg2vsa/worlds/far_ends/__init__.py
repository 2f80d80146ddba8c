"""The far ends of the wires: firmware, boxes, base stations and cameras that answer the drivers byte by byte."""
