"""Compiled core: arrays in, arrays out. Nothing here knows a mechanism, a file or a picture."""
