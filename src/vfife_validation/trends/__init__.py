"""Trends over clearance and speed beside statements of the literature (``vfife verify trends``)."""
