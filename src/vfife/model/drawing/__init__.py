"""Strokes by which joints, gears and springs are drawn."""
