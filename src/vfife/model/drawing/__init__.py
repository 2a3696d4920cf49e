"""Drawings of joints, gears and springs as strokes."""
