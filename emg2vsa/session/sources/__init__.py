"""Devices that hand over EMG and force as blocks on the session's clock: each a `emg2vsa.session.streams.Source`."""
