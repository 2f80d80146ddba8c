"""Arithmetic of signals: filters, envelopes, co-contraction, segmentation, and what is wrong with a channel."""
