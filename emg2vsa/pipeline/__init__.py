"""Which steps of a study are stale, and running them in several processes; ``stages`` has one file per stage."""
