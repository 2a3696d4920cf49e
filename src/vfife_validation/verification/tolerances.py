"""Largest tolerances by case: some thirty times the largest error found.

A run has the same bits on every machine, so that its error does not scatter; the factor leaves room for other
versions of the reference's integrator. A tolerance a thousand times the error would let a lost digit pass.
Cases that are not listed have errors near their tolerances.
"""

LARGEST = {
    "flying-beam": 3e-5, "lumped-inertia": 3e-5,
    "gear-pair": 1e-11, "planetary-train": 1e-6, "motor-curve": 1e-7, "torque-over-angle": 5e-5,
    "following-force": 1e-5, "driven-point": 2e-6, "imposed-turns": 2e-9,
    "welded-arm": 2e-4, "elastic-guide": 1e-4,
    "four-bar-ideal": 3e-4, "four-bar-with-play": 2e-4,
    "slider-on-rotating-arm": 2e-7, "bead-on-free-rod": 3e-8, "scotch-yoke": 1e-6, "quick-return": 1e-5,
    "driven-travel": 2e-7,
    "redundant-parallelogram": 5e-7,
    "spring-mass-damper": 5e-5, "torsional-oscillator": 3e-6, "bushing-oscillator": 3e-5,
    "mass-proportional-damping": 1e-5,
    "double-pendulum": 8e-5, "closed-chain": 3e-5, "double-four-bar-turns": 2e-4,
    "motor-between-two-rods": 5e-8,
    "andrews-squeezer": 3e-6,
}  # fmt: skip
