"""The page that runs a mechanism: its data, sliders, strokes and scripts."""
