"""A mechanism edited as a sketch: operations on its model file, and its ideal motion for drawing."""
