"""
A motor with a speed controller
===============================

A direct-current motor turns a rotor, a controller maintains its speed, and a brake engages. Motor and
controller are another program, here a few lines. ``vfife.Simulation`` advances the mechanism between their
calls, with the same bits as an uninterrupted run.
"""

# %%
# The mechanism is a rotor on its pivot with two torques, of the motor and of the brake.

import math

import numpy as np
from scipy.integrate import solve_ivp

import vfife

INERTIA, RESISTANCE, INDUCTANCE, CONSTANT = 2e-4, 0.5, 1e-3, 0.05  # kg m^2, ohm, H, N m/A
GAIN, INTEGRAL = 0.2, 8.0  # V s/rad, V/rad
TARGET, BRAKE, BRAKED, END = 150.0, -0.2, 0.1, 0.2  # rad/s, N m, s, s
SAMPLE, EXCHANGE = (1e-3, 5e-5)  # s: sampling intervals of the controller and of the motor


def rotor() -> vfife.Mechanism:
    """Return a rotor with two torques, which are zero until they are set."""
    m = vfife.Mechanism("rotor")
    m.point("O", 0, 0)
    m.rigid_body("rotor", mass="0.5 kg", inertia=INERTIA)
    m.revolute("shaft", "ground.O", "rotor.center")
    m.drivers["motor"] = vfife.drivers.Torque(body="rotor", value=0.0)
    m.drivers["brake"] = vfife.drivers.Torque(body="rotor", value=0.0)
    return m


# %%
# The control loop. Every millisecond the controller samples the speed and sets a voltage with a proportional
# and an integral part. Every 50 microseconds the motor reads the speed, integrates its current,
# L di/dt = U - R i - K w, and returns the mean of its torque, K i.


def controlled(exchange: float = EXCHANGE) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) and speeds (rad/s) at the samples of the controller."""
    simulation = vfife.Simulation(rotor(), step=exchange / 10)
    speed = simulation.channel("rotor.angular_velocity")
    decay = math.exp(-RESISTANCE / INDUCTANCE * exchange)
    mean = (1.0 - decay) * INDUCTANCE / (RESISTANCE * exchange)  # of a decaying current, over an exchange
    times, speeds, current, summed = [], [], 0.0, 0.0
    for sample in range(round(END / SAMPLE)):
        now = sample * SAMPLE
        times.append(now)
        speeds.append(speed())
        summed += SAMPLE * (TARGET - speed())
        voltage = GAIN * (TARGET - speed()) + INTEGRAL * summed
        simulation.set("brake", BRAKE if now >= BRAKED - 1e-9 else 0.0)
        for k in range(1, round(SAMPLE / exchange) + 1):
            settled = (voltage - CONSTANT * speed()) / RESISTANCE
            simulation.set("motor", CONSTANT * (settled + (current - settled) * mean))
            current = settled + (current - settled) * decay
            simulation.advance(now + k * exchange)
    return np.array(times), np.array(speeds)


# %%
# For comparison, SciPy integrates the same motor and controller with the rotor as an inertia:
# J dw/dt = K i + brake.


def reference() -> np.ndarray:
    """Return speeds (rad/s) at the same times."""
    speeds, state, summed = [], np.zeros(2), 0.0
    for sample in range(round(END / SAMPLE)):
        speeds.append(state[0])
        summed += SAMPLE * (TARGET - state[0])
        voltage = GAIN * (TARGET - state[0]) + INTEGRAL * summed
        brake = BRAKE if sample * SAMPLE >= BRAKED - 1e-9 else 0.0

        def rates(_: float, y: np.ndarray, u: float = voltage, load: float = brake) -> tuple[float, float]:
            return (CONSTANT * y[1] + load) / INERTIA, (u - RESISTANCE * y[1] - CONSTANT * y[0]) / INDUCTANCE

        state = solve_ivp(rates, (0.0, SAMPLE), state, rtol=1e-10, atol=1e-12).y[:, -1]
    return np.array(speeds)


times, speeds = controlled()
expected = reference()
away = np.abs(speeds - expected).max() / TARGET
before, lowest = speeds[times < BRAKED][-1], speeds[times > BRAKED].min()
print(
    f"speed {before:.1f} rad/s before the brake, at least {lowest:.1f} rad/s after it; at most "
    f"{100.0 * away:.3f} % from SciPy"
)

# %%
# Speed at the samples of the controller, with that of SciPy.

from matplotlib.figure import Figure

figure = Figure(figsize=(7.0, 3.0), layout="constrained")
axes = figure.subplots()
axes.plot(times, expected, color="0.7", lw=4, label="SciPy")
axes.plot(times, speeds, label="vfife.Simulation")
axes.set(xlabel="time (s)", ylabel="speed (rad/s)")
axes.legend()

# %%
# The exchange of numbers between two programs every 50 microseconds is a method of first order: half the
# interval halves the difference.

finer = np.abs(controlled(EXCHANGE / 2)[1] - expected).max() / TARGET
print(f"with half the interval: {100.0 * finer:.3f} %")
assert away < 2e-3 and 0.4 < finer / away < 0.6
