"""Tutorial in cells of text and code; `make tutorial` runs it and writes verdict.md."""

# %% [markdown]
# # From raw logs to a verdict
#
# A rig logs the torque and speed of its top drive while a small torque sweep is injected. This page goes from two such
# logs to the parameters of the string, and asks what the model gets wrong. The logs are simulated, so that the answer
# is known: the drive's torque loop has a lag of 50 ms that no data sheet mentions. Every number and figure below comes
# from the code above it (`make tutorial`).

# %%
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pandas as pd

import drillid
from drillid.excitation.torques import coloured_noise, exponential_sweeps
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive, polar_moment
from drillid.simulation.simulate import TIME_STEP, simulate

RPM = 30 / np.pi
folder = Path(mkdtemp())

# %% [markdown]
# ## The rig, and what is wrong with it
#
# 1820 m of 5½" pipe and 80 m of collars hang on a top drive under soft speed control. `lag` is the time constant of the
# torque loop: what the controller asks for arrives late and smoothed.

# %%
pipe = Section(1820.0, polar_moment(0.1397, 0.1214), kappa=150.0, delta=2.5e8)
collars = Section(80.0, polar_moment(0.1651, 0.0714), kappa=150.0, delta=2.5e8)
control = Controller(proportional=1500.0, integral=800.0)
rig = DrillingSystem(TopDrive(1100.0, 0.035, control, lag=0.05), (pipe, collars), Bit(40.0, 40.0))

# %% [markdown]
# ## Two logs
#
# Each log is a stand of twenty minutes at 120 rpm. Three exponential sweeps of 500 N m go into the torque command, and
# the rock shakes the bit with 300 N m rms. The rig's recorder writes 50 rows a second, rounded and time-stamped.


# %%
def stand(number: int) -> Path:
    """Simulate a stand and write its log."""
    time = np.arange(0, 1320, TIME_STEP)
    shaking = coloured_noise(np.random.default_rng(number), time.size, TIME_STEP, 300.0, 2.0)
    sweep = exponential_sweeps(time, 500.0)
    drilled = simulate(rig, sweep, np.full(time.size, 120 / RPM), 5000.0 + shaking, mean_bit_torque=5000.0)
    depth = 1900 + 9.0 * number + 0.0075 * drilled.time
    begin = pd.Timestamp("2025-03-03T06:00:00Z") + pd.Timedelta(minutes=30 * number)
    log = pd.DataFrame(
        {
            "Time": begin + pd.to_timedelta(drilled.time, unit="s"),
            "SWEEP": (exponential_sweeps(drilled.time, 500.0) / 1e3).round(4),
            "TQA": (drilled.torque_command / 1e3).round(4),
            "RPMA": (drilled.speed * RPM).round(3),
            "DMEA": depth.round(3),
        }
    )
    path = folder / f"stand_{number}.csv"
    log[log["Time"] >= begin + pd.Timedelta(minutes=2)].to_csv(path, index=False)
    return path


logs = [stand(number) for number in range(2)]
print(logs[0].read_text()[:330])

# %% [markdown]
# ## What the data sheets say
#
# The description names the log's columns with their units, and states whatever is known with its tolerance. Everything
# but the channels may be left out.

# %%
DESCRIPTION = """\
name: Tutorial rig
channels:
  torque_sweep: {column: SWEEP, unit: kN m}
  torque_command: {column: TQA, unit: kN m}
  speed: {column: RPMA, unit: rpm}
  hole_depth: {column: DMEA, unit: m}
controller: {proportional: 1500 N m s/rad, integral: 800 N m/rad}
drive_delay: {value: 35 ms, tolerance: 3 ms}
top_drive_inertia: {value: 1100 kg m^2, relative: 2 %}
pipe: {outer_diameter: 5.5 in, inner_diameter: 4.778 in}
collars: [{outer_diameter: 6.5 in, inner_diameter: 71.4 mm, length: 80 m}]
"""
(folder / "rig.yaml").write_text(DESCRIPTION)
well = drillid.identify(logs, folder / "rig.yaml")
print(well.windows[["start", "end", "hole_depth"]].to_dataframe().to_string())

# %% [markdown]
# Two stands of twenty minutes hold four windows of ten. `drillid inspect` drafts such a description from a log, and
# `well.problems` lists whatever was corrected or rejected on the way. Here the fits have something to say:

# %%
what = well.problems["what"].str.replace(r" \(p-value.*?\)|; it counts.*", "", regex=True)
print(what.value_counts().rename_axis("what").to_string())

# %% [markdown]
# ## The parameters, and a first doubt
#
# Each window is fitted with the eight parameters of the paper's model. Where that model is right, χ² per degree of
# freedom is about 1, and estimates differ from the true values by about the stated errors.

# %%
truth = {"length": 1820.0, "polar_moment": pipe.polar_moment, "delay": 0.035, "inertia_td": 1100.0}
table = well.parameters.pivot(index="window", columns="parameter", values=["value", "standard_error"])
for name, true in truth.items():
    value, error = table["value"][name], table["standard_error"][name]
    shown = "  ".join(f"{one:.4g} ± {off:.2g}" for one, off in zip(value, error, strict=True))
    print(f"{name:13} true {true:10.4g}   found {shown}")
print("χ² per degree of freedom", well.fits["chi2_per_dof"].values.round(2))

# %% [markdown]
# The model has no lag, so it puts the drive's lateness into the delay, far outside the data sheet's tolerance of 3 ms,
# and distorts inertia and length to make up for the rest. The squared residuals are twice what noise
# would leave, and the fits are not accepted.
#
# ## The verdict
#
# The engine fits all windows and the data sheets together, with each cause of its catalogue in turn. It names a cause
# only if it explains the misfit, nothing else explains it as well, and it predicts windows that it was not fitted to.

# %%
verdict = well.verdicts.iloc[0]
print(f"{verdict.verdict}, probability {verdict.probability:.2f}")
print(
    f"size {1e3 * verdict['size']:.1f} ms, 95 % interval {1e3 * verdict.size_low:.1f} to {1e3 * verdict.size_high:.1f}"
)
print(verdict.evidence)

# %%
evidence = well.draw("evidence")

# %% [markdown]
# The lag is found, with its size. What to do about it is up to the rig: have the drive's torque loop checked, or
# describe the drive as it is. Either way, the depth dataset of a workflow run holds the string's parameters from the
# extended model, and the report says how much better that model predicts the top drive's speed.
