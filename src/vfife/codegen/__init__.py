"""The step as compiled text: gathered from the kernels and the laws, traced into straight lines, scheduled, compiled, run."""
