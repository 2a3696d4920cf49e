"""Compiled code: cache, loading, the loops and streams that call it."""
