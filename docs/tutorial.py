"""Tutorial in cells of text and code; `make tutorial` runs it and writes tutorial.md."""

# %% [markdown]
# # From the equations to a tuned controller
#
# This page walks through the paper *Identification While Drilling of Drill-string Dynamic Model for Diagnostics and
# Optimization*: its equations, the parameters of its Table 1, what they say about the bit, the identification of a
# simulated rig from ten minutes of its log, and a speed controller tuned to what was found. It is a script run from top
# to bottom (`make tutorial`); every number and figure below comes from the code above it.

# %%
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
from matplotlib import pyplot as plt

from drillid.config.listing import Well
from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.control.margins import margins
from drillid.control.stick_slip import simulated_lowest_speed, stick_slip_map
from drillid.control.tuning import controlled_by, first_sample, sampled_systems, tune
from drillid.datasets.store import WellFolders
from drillid.excitation.design import Experiment, lines_within
from drillid.excitation.torques import coloured_noise, coloured_noise_density, exponential_sweeps
from drillid.figures.style import DATA_SHEET, FLAGGED, INK, MUTED, STYLE, frequency_axis
from drillid.fits import stage as fits
from drillid.mobility import stage as mobility
from drillid.physics.eight_parameters import KnownEquipment, drilling_system
from drillid.physics.equipment import Bit, Controller, Section, of_window
from drillid.physics.line import propagation
from drillid.physics.lumped import ladder_string_admittance
from drillid.physics.modes import modes
from drillid.physics.nonlinear import Cutting, Weakening
from drillid.physics.parameters import PARAMETERS
from drillid.physics.responses import bit_mobility, command_mobility, laplace, string_admittance
from drillid.physics.stability import loop_transfer
from drillid.physics.time_responses import bit_step_response
from drillid.records import stage as records
from drillid.simulation.simulate import TIME_STEP, simulate
from drillid.spectra import stage as spectra
from drillid.windows import stage as windows

plt.rcParams.update(STYLE)
plt.rcParams["figure.constrained_layout.use"] = True
RPM = 30 / np.pi
BAND = (0.05, 5.0)

# %% [markdown]
# ## A length of pipe
#
# Angular speed plays the part of voltage, and torque that of current. With the damping κ of mud and wall and the
# internal damping δ of the steel, equations 1 and 2 are
#
# $$\alpha = \rho s + \kappa, \qquad \beta = \frac{G}{s} + \delta,$$
#
# and a uniform length *L* of polar moment *IP* has the propagation coefficient γ = √(α/β) per metre and the
# characteristic admittance Y₀ = IP √(αβ). Equation 5 relates its two ends:
#
# $$\begin{bmatrix}\omega_1\\T_1\end{bmatrix} = \begin{bmatrix}\cosh\gamma L & Z_0\sinh\gamma L\\
# Y_0\sinh\gamma L & \cosh\gamma L\end{bmatrix}\begin{bmatrix}\omega_2\\T_2\end{bmatrix}.$$
#
# The string of row A of Table 1:

# %%
pipe = Section(length=4455.0, polar_moment=1.633e-5, kappa=217.0, delta=2.354e8)
frequency = np.array([0.1, 1.0, 4.0])
gamma, admittance = propagation(pipe, laplace(frequency))
for f, g, y in zip(frequency, gamma, admittance, strict=True):
    print(
        f"{f:.1f} Hz: a wave is {2 * np.pi / g.imag / 1e3:5.2f} km long and keeps {np.exp(-g.real * pipe.length):4.0%} "
        f"on its way down; |Y₀| = {abs(y):.0f} N m s/rad"
    )

# %% [markdown]
# The paper builds the same string from many lumped fractions (figures 2 to 4). Each element below has half of its
# inertia at either end. One element, the lumped model of most controllers, gets nothing right above the first mode.

# %%
frequency = np.geomspace(*BAND, 400)
s = laplace(frequency)
TABLE_1 = pd.DataFrame(
    {
        "A": [217, 2.354e8, 4455, 1.633e-5, 0.03899, 1104, 2.141e-13, 85.98],
        "B": [4.235, 3.717e8, 4460, 1.67e-5, 0.04036, 1123, 0.03716, 84.43],
        "C": [1.011e-10, 3.92e8, 4400, 1.689e-5, 0.0426, 1093, 7.565e-5, 103.90],
        "D": [2.559e-14, 4.23e8, 4443, 1.571e-5, 0.0417, 1098, 3.593, 81.58],
        "E": [80.09, 2.749e8, 4430, 1.562e-5, 0.03916, 1093, 9.571e-13, 82.15],
        "F": [76.18, 3.191e8, 4472, 1.601e-5, 0.04075, 1112, 4.704e-15, 77.62],
        "stacked": [0.05795, 6.348e8, 4488, 1.575e-5, 0.03895, 1113, 2.264e-13, 75.20],
    },
    index=list(PARAMETERS),
).T  # the paper's Table 1
REPORTED = Controller(proportional=1500.0, integral=800.0)
systems = {name: drilling_system(row.to_numpy(), KnownEquipment(REPORTED)) for name, row in TABLE_1.iterrows()}
row_a = systems["A"]
line = string_admittance(row_a, s)
for elements in (1, 10, 100, 1000):
    error = np.abs(ladder_string_admittance(row_a, s, elements) / line - 1)
    worst = [error[frequency < limit].max() for limit in (0.1, 1.0, 5.0)]
    print(f"{elements:5} elements: off by {worst[0]:7.0e} to 0.1 Hz, {worst[1]:7.0e} to 1 Hz, {worst[2]:7.0e} to 5 Hz")

# %% [markdown]
# ## Command mobility
#
# The top drive of figure 1 has the inertia J_td, a drive with the delay T_d, and a speed controller A = P + I/s, here
# with P = 1500 N m s/rad and I = 800 N m/rad. The sweep is added to the torque that the controller commands; the
# response of the speed to it is the command mobility
#
# $$M = \frac{\omega_{td}}{T_{sweep}} = \frac{e^{-sT_d}}{J_{td}s + Y_{in} + e^{-sT_d}A}.$$
#
# All of Table 1, as in the paper's figure 8:

# %%
figure, (above, below) = plt.subplots(2, 1, figsize=(7.5, 5.5), sharex=True, num="Command mobility of Table 1")
for name, system in systems.items():
    response = command_mobility(system, s)
    look = {"color": FLAGGED, "linewidth": 2} if name == "stacked" else {"color": INK if name == "A" else DATA_SHEET}
    label = name if name in ("A", "stacked") else "B to F" if name == "B" else "_"
    above.plot(frequency, np.abs(response) * 1e3 * RPM, label=label, **look)
    below.plot(frequency, np.degrees(np.unwrap(np.angle(response))), **look)
above.set(ylabel="Speed per torque [rpm/(kN m)]", yscale="log", title="Command mobility, Table 1")
above.set_yticks(ticks := [0.2, 0.5, 1, 2, 5], [f"{tick:g}" for tick in ticks])
above.minorticks_off()
above.legend()
frequency_axis(above, BAND, label=False)
frequency_axis(below, BAND)
below.set_ylabel("Phase [°]")

# %% [markdown]
# The dips lie near the modes of the string with its upper end clamped: there the string holds the top drive still. The
# peaks lie near the modes of the whole rig under control. Modes are poles in the complex plane, found without a
# frequency grid; damping moves a peak slightly away from its pole, the more so the heavier it is.

# %%
fine = np.geomspace(0.05, 2.0, 40000)
size = np.abs(command_mobility(row_a, laplace(fine)))
inner = size[1:-1]
dips = fine[1:-1][(inner < size[:-2]) & (inner < size[2:])]
peaks = fine[1:-1][(inner > size[:-2]) & (inner > size[2:])]
clamped, controlled = modes(row_a, highest=1.9, stiff=True), modes(row_a, highest=1.6)
print("dips of |M|      ", " ".join(f"{one:.3f}" for one in dips), "Hz")
print("clamped modes    ", " ".join(f"{one:.3f}" for one in clamped.frequency), "Hz")
print("their damping    ", " ".join(f"{one:5.1%}" for one in clamped.damping_ratio))
print("peaks of |M|     ", " ".join(f"{one:.3f}" for one in peaks), "Hz")
print("controlled modes ", " ".join(f"{one:.3f}" for one in controlled.frequency), "Hz")
print("their damping    ", " ".join(f"{one:5.1%}" for one in controlled.damping_ratio))

# %% [markdown]
# ## What the bit feels
#
# The bit's mobility is its speed per unit of torque on it. No measurement at the surface shows it, but the model does.
# With a stiff top drive the string rings; the reported controller, a soft torque, removes the first mode and leaves the
# higher ones, where the top drive's inertia stands in its way.

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 4.0), num="Bit mobility and step response")
for name, (stiff, colour) in {"stiff top": (True, FLAGGED), "soft torque": (False, INK)}.items():
    left.plot(frequency, np.abs(bit_mobility(row_a, s, stiff=stiff)) * 1e3 * RPM, color=colour, label=name)
    lags, speed = bit_step_response(row_a, 20.0, 0.02, stiff=stiff)
    right.plot(lags, speed * 1e3 * RPM, color=colour, label=name)
left.set(ylabel="Bit speed per torque [rpm/(kN m)]", yscale="log", title="Bit mobility, row A")
frequency_axis(left, BAND)
right.set(
    xlabel="Time after the step [s]",
    ylabel="Bit speed per torque [rpm/(kN m)]",
    title="After a step of torque at the bit",
)
left.legend()
for name, stiff in (("stiff top", True), ("soft torque", False)):
    lags, speed = bit_step_response(row_a, 20.0, 0.02, stiff=stiff)
    late = np.std(speed[lags > 13]) / np.std(speed[lags < 7])
    highest = frequency[np.abs(bit_mobility(row_a, s, stiff=stiff)).argmax()]
    print(f"{name}: largest bit mobility at {highest:.2f} Hz; motion after 13 s {late:.0%} of that before 7 s")

# %% [markdown]
# ## Ten minutes of a log, and what they tell
#
# A rig with the parameters of row A, and a bit that damps, drills for twelve minutes in the time-domain simulator. The
# simulator shares no formula with the model above: it moves waves through several hundred inertias and springs, step by
# step. Three exponential sweeps of 500 N m each go into the torque command; the rock shakes the bit with 500 N m rms
# below 2 Hz. The log is written at 50 Hz, with a rig's units and rounding.

# %%
truth = first_sample(replace(row_a, bit=Bit(85.98, 40.0)))
actual = np.concatenate([TABLE_1.loc["A"].to_numpy()[:6], [40.0, 85.98]])
time = np.arange(0, 720, TIME_STEP)
shaking = coloured_noise(np.random.default_rng(1), time.size, TIME_STEP, 500.0, 2.0)
drilled = simulate(
    truth, exponential_sweeps(time, 500.0), np.full(time.size, 12.0), 6000.0 + shaking, mean_bit_torque=6000.0
)
log = pd.DataFrame(
    {
        "TIME": pd.Timestamp("2025-03-03T06:00:00Z") + pd.to_timedelta(drilled.time, unit="s"),
        "TQ_SWEEP": (exponential_sweeps(drilled.time, 500.0) / 1e3).round(4),
        "TQ_CMD": (drilled.torque_command / 1e3).round(4),
        "RPM": (drilled.speed * RPM).round(3),
        "HOLE": (4455 + 0.005 * drilled.time).round(3),
        "BIT": (4455 + 0.005 * drilled.time).round(3),
    }
)
print(log.iloc[::7200].to_string(index=False))

# %% [markdown]
# The rig is described as in `config/rigs`, here with nothing but its columns and its controller, and the stages of the
# workflow take the log from raw rows to parameters.

# %%
CHANNELS = {
    "torque_sweep": {"column": "TQ_SWEEP", "unit": "kN m"},
    "torque_command": {"column": "TQ_CMD", "unit": "kN m"},
    "speed": {"column": "RPM", "unit": "rpm"},
    "hole_depth": {"column": "HOLE", "unit": "m"},
    "bit_depth": {"column": "BIT", "unit": "m"},
}
CONTROL = {"proportional": "1500 N m s/rad", "integral": "800 N m/rad"}
rig = Rig.checked(
    {"name": "tutorial", "time": {"column": "TIME"}, "channels": CHANNELS, "controller": CONTROL}, "tutorial"
)
with TemporaryDirectory() as results:
    raw = Path(results) / "log.csv"
    log.to_csv(raw, index=False)
    well, folders = Well("T01", rig, (raw,)), WellFolders(Path(results), "T01")
    for stage in (records, windows, spectra, mobility, fits):
        for problem in stage.process(well, folders, Settings()):
            print(f"{stage.__name__.split('.')[1]}: {problem.where}: {problem.what}")
    measured, fitted = (folders.read(*one).load().isel(window=0) for one in (("mobility",) * 2, ("fits",) * 2))
print(f"{measured.frequency.size} frequencies, {int((measured.gate == 0).sum())} of them pass the coherence gate")

# %% [markdown]
# Beside each estimate stand its standard error and the smallest error that any unbiased method could have, the
# Cramér–Rao bound for this sweep, noise and duration. Length, polar moment, delay and the top drive's inertia are well
# known after ten minutes. The dampings are not, by this fit or by the bound; the bound on δ may even be undercut, as
# the fit has a prior on δ: its usual size, within a factor of three. Where noise makes the resonances look sharper than
# they are, their frequencies, and with them the length, look better known than they are.

# %%
shaking_frequency = np.geomspace(0.005, 25.0, 600)
experiment = Experiment(
    actual, KnownEquipment(REPORTED), shaking_frequency, coloured_noise_density(shaking_frequency, 500.0, 2.0), 600.0
)
period = exponential_sweeps(np.arange(0, 120, 0.02), 500.0)
bound = experiment.standard_errors(*lines_within(period, 50.0, (0.05, 4.0)))
value, error = fitted["value"].to_numpy(), fitted["standard_error"].to_numpy()
print(f"{'':14}{'true':>11}{'found':>11}{'error':>10}{'bound':>10}{'off/error':>11}")
for name, *row in zip(PARAMETERS, actual, value, error, bound, strict=True):
    off = (row[1] - row[0]) / row[2]
    print(f"{name:14}{row[0]:11.4g}{row[1]:11.4g}{row[2]:10.2g}{row[3]:10.2g}{off:11.1f} {PARAMETERS[name][0]}")
print(f"χ² per degree of freedom {float(fitted.chi2_per_dof):.2f}")

# %%
identified = drilling_system(value, KnownEquipment(REPORTED))
used = (measured.gate == 0).to_numpy()
points = measured.frequency.to_numpy()[used], np.abs(measured.command_mobility.to_numpy()[used]) * 1e3 * RPM
spread = np.sqrt(measured.command_mobility_variance.to_numpy()[used] / 2) * 1e3 * RPM
figure, axis = plt.subplots(figsize=(7.5, 4.0), num="Measured and fitted mobility")
axis.errorbar(
    *points, spread, fmt=".", color=DATA_SHEET, markersize=3, elinewidth=0.6, label="measured, ± one deviation"
)
axis.plot(frequency, np.abs(command_mobility(truth, s)) * 1e3 * RPM, color=FLAGGED, label="true")
axis.plot(frequency, np.abs(command_mobility(identified, s)) * 1e3 * RPM, color=INK, linestyle="--", label="fitted")
axis.set(ylabel="Speed per torque [rpm/(kN m)]", yscale="log", title="Ten minutes of simulated drilling")
frequency_axis(axis, BAND)
axis.set_ylim(0.1, 12)
axis.legend()

# %% [markdown]
# ## A controller for this string
#
# The controller is tuned to what was found and to how well it was found. The worst of twelve draws from the fit's
# uncertainty decides: its largest bit mobility between 0.05 and 3 Hz is minimised, while all draws keep the gain, phase
# and modulus margins of the whole loop with its delay.

# %%
correlation = fitted["correlation"].to_numpy()
samples = sampled_systems(value, correlation * np.outer(error, error), KnownEquipment(REPORTED))
soft = tune(samples, "proportional integral")
matched = tune(samples, "impedance matching")
controllers = {
    "stiff": Controller(20000.0, 20000.0),
    "as reported": REPORTED,
    "tuned soft torque": soft.controller,
    "impedance matched": matched.controller,
}
for name, controller in controllers.items():
    ruled = controlled_by(samples, controller)
    kept = margins(lambda s, ruled=ruled: loop_transfer(ruled, s))
    largest = np.abs(bit_mobility(ruled, laplace(np.linspace(0.05, 3.0, 400)))).max() * 1e3 * RPM
    print(
        f"{name:18} bit mobility at most {largest:5.1f} rpm/(kN m); gain margin {kept.gain.min():4.1f}, "
        f"phase margin {np.degrees(kept.phase.min()):3.0f}°, largest sensitivity {kept.sensitivity.max():.2f}"
    )
for name, tuning in {"tuned soft torque": soft, "impedance matched": matched}.items():
    print(f"{name}: " + ", ".join(f"{key} {number:.3g} {unit}" for key, (number, unit) in tuning.in_units().items()))

# %%
COLOURS = dict(zip(controllers, (FLAGGED, MUTED, INK, "#4f8f6b"), strict=True))
figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 4.0), num="Bit under four controllers")
for name, controller in controllers.items():
    ruled = controlled_by(truth, controller)
    left.plot(frequency, np.abs(bit_mobility(ruled, s)) * 1e3 * RPM, color=COLOURS[name], label=name)
    lags, speed = bit_step_response(ruled, 20.0, 0.02)
    right.plot(lags, speed * 1e3 * RPM, color=COLOURS[name])
left.set(ylabel="Bit speed per torque [rpm/(kN m)]", yscale="log", title="Bit mobility of the true rig")
frequency_axis(left, BAND)
left.legend()
right.set(
    xlabel="Time after the step [s]",
    ylabel="Bit speed per torque [rpm/(kN m)]",
    title="After a step of torque at the bit",
)

# %% [markdown]
# A bit whose torque falls with speed has negative damping, and below some speed more of it than string and controller
# can absorb: stick-slip sets in. The map shows that speed for a bit whose torque falls from 60 to 30 N m per kN of
# weight, by the identified linear model. The bars, all at 100 kN, span the draws from the model's uncertainty. The
# circles are the speeds below which a small vibration of the true rig grows in the time-domain simulator.
#
# Under a stiff top drive nothing but the string's own damping opposes the bit. Ten minutes hardly determine that
# damping, so the prediction is wide. A controller that absorbs the waves brings a damping of its own, which is known.

# %%
cutting = Cutting(0.06, 0.03, Weakening(6.0))
weights, weight = np.linspace(2e4, 2e5, 37), np.array([1e5])
draws = [of_window(samples, (number,), (12,)) for number in range(12)]
found = stick_slip_map(first_sample(identified), cutting, weights, controllers)
drawn = [stick_slip_map(draw, cutting, weight, controllers) for draw in draws]
spans = {name: [one.speed[name][0] * RPM for one in drawn] for name in controllers}
exact = stick_slip_map(truth, cutting, weight, controllers)
figure, axis = plt.subplots(figsize=(7.5, 4.2), num="Stick-slip map")
for name, lowest in found.speed.items():
    axis.plot(weights / 1e3, lowest * RPM, color=COLOURS[name], label=f"{name}, {found.frequency[name]:.2f} Hz")
    place = 97 + 2 * list(controllers).index(name)
    axis.vlines(place, min(spans[name]), max(spans[name]), COLOURS[name], linewidth=3, alpha=0.4)
    bracket = (0.93 * exact.speed[name][0], 1.07 * exact.speed[name][0])
    simulated = simulated_lowest_speed(controlled_by(truth, controllers[name]), cutting, weight[0], bracket) * RPM
    axis.plot(place, simulated, "o", color=COLOURS[name], markerfacecolor="white")
    print(
        f"{name:18} at 100 kN from {np.interp(1e5, weights, lowest) * RPM:4.0f} rpm by the fit, "
        f"{min(spans[name]):3.0f} to {max(spans[name]):3.0f} by its draws; "
        f"true rig from {exact.speed[name][0] * RPM:4.0f}, in the simulator {simulated:4.0f}"
    )
axis.set(
    xlabel="Weight on bit [kN]", ylabel="Lowest stable speed [rpm]", title="Stick-slip below each line", ylim=(0, None)
)
axis.legend()
