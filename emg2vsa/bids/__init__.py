"""BIDS-EMG (1.11.1) as files: what a data set holds is told as plain data; names, columns and keys are known here."""
