"""The page that runs a mechanism: its numbers, sliders, strokes and scripts."""
