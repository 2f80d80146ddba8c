"""A card of National Instruments: gauges of a force transducer, EMG of an amplifier."""
