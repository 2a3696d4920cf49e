"""vfife beside measurements (``vfife verify measured``): pendulums, single and double, a hysteresis loop."""
