"""Cases of a study: assembled, run on lanes, cores or clusters, and filed."""
