"""Every dataset's dimensions, dtypes, units and meaning, in one place; CF conventions where CF has one."""

import enum

from drillid.declaration import DatasetSchema, Variable, each
from drillid.schema_discrepancy import DISCREPANCIES as DISCREPANCIES
from drillid.schema_discrepancy import EXAMINATIONS as EXAMINATIONS
from drillid.schema_windows import AT_FREQUENCIES, IN_WINDOWS, MOBILITY
from drillid.schema_windows import WINDOW_COORDINATES as WINDOW_COORDINATES
from drillid.schema_windows import WINDOW_FREQUENCY as _WF

PARAMETERS = {
    "kappa": ("N s m-4", "external viscous damping of mud and wall"),
    "delta": ("N s m-2", "internal damping of the steel"),
    "length": ("m", "length of the drill pipe"),
    "polar_moment": ("m4", "polar moment of the drill pipe"),
    "delay": ("s", "delay of the drive"),
    "inertia_td": ("kg m2", "inertia of the top drive"),
    "damping_bha": ("N m s rad-1", "viscous damping of the bottom-hole assembly"),
    "inertia_bha": ("kg m2", "inertia of the bottom-hole assembly, collars included"),
}
"""The eight parameters of the paper's model: CF unit and meaning, in the order used everywhere."""


class RigState(enum.IntEnum):
    """What the rig does at one sample."""

    UNKNOWN = 0
    DRILLING = 1
    CONNECTION = 2
    OFF_BOTTOM = 3
    REAMING = 4
    SWEEP_OFF = 5


class RecordFlag(enum.IntFlag):
    """What was done to, or is wrong with, one sample of a record."""

    INTERPOLATED = 1
    GAP = 2
    SPIKE = 4
    STUCK = 8
    DUPLICATE = 16
    CLOCK_STEP = 32


class Gate(enum.IntEnum):
    """Why a frequency is used or left out."""

    USED = 0
    OUTSIDE_SWEEP = 1
    TOO_INCOHERENT = 2
    TOO_COHERENT = 3


class Knowledge(enum.IntEnum):
    """What one window tells of a parameter."""

    KNOWN = 0
    BOUNDED_ABOVE = 1
    BOUNDED_BELOW = 2
    UNDETERMINED = 3


_CHANNELS = {
    "torque_command": ("N m", "torque command to the drive, sweep included"),
    "torque_sweep": ("N m", "injected torque sweep"),
    "speed": ("rad s-1", "top-drive speed"),
    "speed_set": ("rad s-1", "set point of the top-drive speed"),
    "hole_depth": ("m", "measured depth of the hole"),
    "bit_depth": ("m", "measured depth of the bit"),
    "weight_on_bit": ("N", "weight on bit"),
    "flow": ("m3 s-1", "mud flow in"),
    "standpipe_pressure": ("Pa", "stand-pipe pressure"),
    "hook_load": ("N", "hook load"),
}

RECORDS = DatasetSchema(
    "Regular records of a well's rig logs",
    {
        "time": Variable(("time",), "datetime64[ns]", "", "time, UTC"),
        **each(("time",), "float32", **_CHANNELS),
        "flags": Variable(("time",), "uint8", "", "what was done to the sample", RecordFlag),
        "log": Variable(("time",), "int16", "", "number of the log file, in order of time"),
    },
)

STATES = DatasetSchema(
    "State of the rig at every sample of the records",
    {
        "time": Variable(("time",), "datetime64[ns]", "", "time, UTC"),
        "rig_state": Variable(("time",), "int8", "", "state of the rig", RigState),
    },
)

WINDOWS = DatasetSchema(
    "Windows of steady drilling with the sweep on",
    {
        **IN_WINDOWS,
        **each(
            ("window",),
            depth_from=("m", "hole depth at the window's start"),
            depth_to=("m", "hole depth at the window's end"),
            bit_depth=("m", "mean bit depth"),
            speed=("rad s-1", "mean top-drive speed"),
            torque=("N m", "mean torque command"),
            weight_on_bit=("N", "mean weight on bit"),
            flow=("m3 s-1", "mean mud flow"),
            sweep_amplitude=("N m", "root mean square of the injected sweep"),
            flagged_share=("1", "share of interpolated or replaced samples"),
        ),
        "first_sample": Variable(("window",), "int64", "", "index of the first sample in the records"),
        "samples": Variable(("window",), "int64", "", "number of samples"),
    },
    WINDOW_COORDINATES[1:],
)

_SPECTROGRAM = ("window", "spectrogram_frequency", "spectrogram_time")

SPECTRA = DatasetSchema(
    "Cross spectra and spectrograms of each window",
    {
        **IN_WINDOWS,
        **AT_FREQUENCIES,
        **each(
            _WF,
            sweep_power=("N2 m2", "mean squared amplitude of the sweep"),
            speed_power=("rad2 s-2", "mean squared amplitude of the speed"),
            speed_noise=("rad2 s-2", "variance of the speed's amplitude not due to the sweep, per average"),
            command_noise=("N2 m2", "variance of the torque command's amplitude not due to the sweep, per average"),
            sweep_rounding=("N2 m2", "mean squared amplitude that the steps of a repeating sweep's record add to it"),
        ),
        **each(
            _WF,
            "complex128",
            cross_speed=("N m rad s-1", "cross spectrum of speed and sweep"),
            cross_command=("N2 m2", "cross spectrum of torque command and sweep"),
            cross_noise=("N m rad s-1", "covariance of speed and torque command not due to the sweep, per average"),
        ),
        "averages": Variable(_WF, "float64", "1", "equivalent number of independent averages"),
        "degrees_of_freedom": Variable(_WF, "float64", "1", "complex degrees of freedom of the noise variance"),
        "sweep_period": Variable(("window",), "float64", "s", "period of the sweep; 0 where it does not repeat"),
        "band": Variable(("band",), "float64", "Hz", "lower edge of the band"),
        "band_end": Variable(("band",), "float64", "Hz", "upper edge of the band"),
        **each(
            ("window", "band"),
            response_level=("rad s-1", "root mean square of the speed's response in the band"),
            noise_level=("rad s-1", "root mean square of the noise of the mean of all periods"),
            even_level=("rad s-1", "root mean square of distortion of even order, beyond the noise"),
            odd_level=("rad s-1", "root mean square of distortion of odd order, beyond the noise"),
        ),
        "even_detected": Variable(("window", "band"), "bool", "", "distortion of even order is beyond chance"),
        "odd_detected": Variable(("window", "band"), "bool", "", "distortion of odd order is beyond chance"),
        "spectrogram_time": Variable(("spectrogram_time",), "float64", "s", "time since the window's start"),
        "spectrogram_frequency": Variable(("spectrogram_frequency",), "float64", "Hz", "frequency of the spectrograms"),
        "torque_spectrogram": Variable(_SPECTROGRAM, "float32", "N2 m2 Hz-1", "power of the torque command"),
        "speed_spectrogram": Variable(_SPECTROGRAM, "float32", "rad2 s-2 Hz-1", "power of the top-drive speed"),
    },
    WINDOW_COORDINATES[1:],
)


def _mobility(row: str) -> dict[str, Variable]:
    dims = (row, "frequency")
    return {
        "command_mobility": Variable(
            dims, "complex128", MOBILITY, "command mobility: top-drive speed per injected torque"
        ),
        "command_mobility_variance": Variable(
            dims, "float64", f"({MOBILITY})2", "variance of the complex command mobility"
        ),
        "averages": Variable(dims, "float64", "1", "equivalent number of independent averages"),
        "degrees_of_freedom": Variable(dims, "float64", "1", "complex degrees of freedom of the variance"),
        "coherence": Variable(dims, "float64", "1", "squared coherence of speed and sweep"),
        "coherence_minimum": Variable(dims, "float64", "1", "least coherence of the band that passes the gate"),
        "coherence_maximum": Variable(dims, "float64", "1", "largest coherence that passes the gate"),
        "gate": Variable(dims, "int8", "", "why the frequency is used or left out", Gate),
    }


_LOOP = {
    **each(
        _WF,
        "complex128",
        torque_mobility=(MOBILITY, "top-drive speed per torque command, free of the controller"),
        control_response=("N m s rad-1", "torque command taken back per top-drive speed: controller and its filters"),
    ),
    **each(
        _WF,
        torque_mobility_variance=(f"({MOBILITY})2", "variance of the complex torque mobility"),
        control_response_variance=("(N m s rad-1)2", "variance of the complex control response"),
        control_response_rounding=("(N m s rad-1)2", "variance by the sweep's steps, the same error in all windows"),
    ),
    **each(
        ("window",),
        channel_offset=("s", "time by which the torque command is recorded later than the sweep"),
        channel_offset_error=("s", "standard error of the channel offset"),
    ),
}

MOBILITIES = DatasetSchema(
    "Command mobility of each window",
    {**IN_WINDOWS, **AT_FREQUENCIES, **_mobility("window"), **_LOOP},
    WINDOW_COORDINATES[1:],
)

STACKS = DatasetSchema(
    "Command mobility of stacked windows",
    {
        "stack": Variable(("stack",), "int32", "", "number of the stack in its well"),
        "hole_depth": Variable(("stack",), "float64", "m", "mean measured depth of the hole"),
        "first_window": Variable(("stack",), "int32", "", "first window of the stack"),
        "last_window": Variable(("stack",), "int32", "", "last window of the stack"),
        "agreement_probability": Variable(
            ("stack",), "float64", "1", "chance of such disagreement between equal windows"
        ),
        "windows": Variable(("stack",), "int32", "", "number of windows in the stack"),
        **AT_FREQUENCIES,
        **_mobility("stack"),
    },
    ("hole_depth", "first_window", "last_window"),
)


def _parameters(row: str) -> dict[str, Variable]:
    dims = (row, "parameter")
    return {
        "parameter": Variable(("parameter",), "str", "", "parameter of the transmission-line model"),
        "parameter_": Variable(("parameter_",), "str", "", "second axis of the correlations"),
        "value": Variable(dims, "float64", "", "fitted value, SI"),
        "standard_error": Variable(dims, "float64", "", "standard error of the fitted value"),
        "interval_lower": Variable(dims, "float64", "", "lower end of the 95 % interval"),
        "interval_upper": Variable(dims, "float64", "", "upper end of the 95 % interval"),
        "status": Variable(dims, "int8", "", "what the window tells of the parameter", Knowledge),
        "at_bound": Variable(dims, "bool", "", "value lies at its physical bound: only one-sided knowledge"),
        "prior": Variable(dims, "float64", "", "value from the rig's papers; NaN where not given"),
        "prior_error": Variable(dims, "float64", "", "standard uncertainty of the value from the rig's papers"),
        "correlation": Variable(
            (row, "parameter", "parameter_"), "float64", "1", "correlation of the parameters' errors"
        ),
        "chi2_per_dof": Variable((row,), "float64", "1", "chi-squared of the residuals per degree of freedom"),
        "residual_dof": Variable((row,), "float64", "1", "degrees of freedom of the residuals"),
        "fit_probability": Variable((row,), "float64", "1", "chance of so large a chi-squared with the right model"),
        "mismatch": Variable(
            (row,), "float64", "1", "factor by which residuals exceed the noise; errors are without it"
        ),
        "accepted": Variable((row,), "bool", "", "the fit is accepted"),
        "reason": Variable((row,), "str", "", "why the fit is not accepted"),
    }


FITS = DatasetSchema(
    "Fitted transmission-line model of each window", {**IN_WINDOWS, **_parameters("window")}, WINDOW_COORDINATES[1:]
)

STACK_FITS = DatasetSchema(
    "Fitted transmission-line model of stacked windows",
    {name: STACKS.variables[name] for name in ("stack", "hole_depth", "first_window", "last_window")}
    | _parameters("stack"),
    ("hole_depth", "first_window", "last_window"),
)

_WP = ("window", "parameter")
JOINT_FITS = DatasetSchema(
    "Fit of all windows together: drive and pipe shared, damping and BHA walking with depth or jumping",
    {
        **IN_WINDOWS,
        "parameter": Variable(("parameter",), "str", "", "parameter of the transmission-line model"),
        "shared": Variable(("shared",), "str", "", "figure that is the same in all windows"),
        "walking": Variable(("walking",), "str", "", "parameter that walks with depth"),
        "value": Variable(_WP, "float64", "", "value, SI"),
        "standard_error": Variable(_WP, "float64", "", "standard error of the value"),
        "lower": Variable(_WP, "float64", "", "lower end of the 95 % band"),
        "upper": Variable(_WP, "float64", "", "upper end of the 95 % band"),
        **each(
            ("window",),
            weight=("1", "share of the window's information that was used"),
            agreement=("1", "chance that a window of the same string is so far from the common fit"),
        ),
        "shared_value": Variable(("shared",), "float64", "", "shared value, SI"),
        "shared_error": Variable(("shared",), "float64", "", "standard error of the shared value"),
        "walk": Variable(("walking",), "float64", "1", "root-mean-square change of the coordinate over 100 m"),
        "change_parameter": Variable(("change",), "str", "", "parameter that jumps"),
        **each(
            ("change",),
            change_depth=("m", "most probable bit depth of the jump"),
            change_from=("m", "shallowest bit depth of the 95 % that hold it"),
            change_to=("m", "deepest bit depth of the 95 % that hold it"),
            change_probability=("1", "probability that there is a jump"),
        ),
        "state": Variable(("state",), "str", "", "coordinate of the newest window's state"),
        "state_": Variable(("state_",), "str", "", "second axis of the state's information"),
        "last_vector": Variable(("state",), "float64", "", "information times mean of the newest window's state"),
        "last_information": Variable(
            ("state", "state_"), "float64", "", "inverse covariance of the newest window's state"
        ),
    },
    WINDOW_COORDINATES[1:],
)

_DF = ("depth", "frequency")
_DL = ("depth", "lag")

DEPTH = DatasetSchema(
    "Identified drilling dynamics against depth",
    {
        "depth": Variable(("depth",), "float64", "m", "mean measured depth of the hole in the window"),
        **AT_FREQUENCIES,
        "lag": Variable(("lag",), "float64", "s", "time since the torque step at the bit"),
        "window": Variable(("depth",), "int32", "", "number of the window in its well"),
        "start": Variable(("depth",), "datetime64[ns]", "", "first sample of the window"),
        "end": Variable(("depth",), "datetime64[ns]", "", "end of the window, exclusive"),
        "state": Variable(("state",), "str", "", "state of the rig"),
        "state_time": Variable(("depth", "state"), "float64", "s", "time in each state since the window before"),
        **each(
            _DF,
            "complex128",
            command_mobility=(MOBILITY, "measured command mobility"),
            command_mobility_fitted=(MOBILITY, "command mobility of the fitted model"),
            bit_mobility_stiff=(MOBILITY, "bit speed per torque on the bit, top drive clamped"),
            bit_mobility_controlled=(MOBILITY, "bit speed per torque on the bit, top drive as controlled"),
        ),
        **each(
            _DF,
            command_mobility_variance=(f"({MOBILITY})2", "variance of the measured command mobility"),
            coherence=("1", "squared coherence of speed and sweep"),
        ),
        "gate": Variable(_DF, "int8", "", "why the frequency is used or left out", Gate),
        **each(
            _DL,
            bit_step_stiff=("rad s-1 N-1 m-1", "bit speed after a unit step of torque, top drive clamped"),
            bit_step_controlled=(
                "rad s-1 N-1 m-1",
                "bit speed after a unit step of torque, top drive as controlled",
            ),
        ),
        **{name: Variable(("depth",), "float64", units, text) for name, (units, text) in PARAMETERS.items()},
        **{
            f"{name}_error": Variable(("depth",), "float64", units, f"standard error of the {text}")
            for name, (units, text) in PARAMETERS.items()
        },
        **each(
            ("depth",),
            chi2_per_dof=("1", "chi-squared of the residuals per degree of freedom"),
            damping_pull=("1", "BHA damping less its run's level, in standard deviations"),
            inertia_pull=("1", "BHA inertia less its run's level, in standard deviations"),
        ),
        **{
            f"{name}_at_bound": Variable(
                ("depth",), "bool", "", f"{text}: at its physical bound, known on one side only"
            )
            for name, (_, text) in PARAMETERS.items()
        },
        **{
            f"{name}_joint{suffix}": Variable(("depth",), "float64", units, f"{end}{text}, from all windows together")
            for name, (units, text) in PARAMETERS.items()
            for suffix, end in (
                ("", ""),
                ("_lower", "lower end of the 95 % band of the "),
                ("_upper", "upper end of the 95 % band of the "),
            )
        },
        "accepted": Variable(("depth",), "bool", "", "the fit is accepted"),
        "flagged": Variable(("depth",), "bool", "", "damping or inertia of the BHA stands out of its run"),
        "verdict": Variable(("depth",), "str", "", "what the simulation gets wrong, by the window's set"),
    },
    ("window", "start", "end"),
)

FLEET = DatasetSchema(
    "Identified drilling dynamics of the fleet, a row a window",
    {
        "well": Variable(("row",), "str", "", "name of the well"),
        **{
            name: Variable(("row",), variable.dtype, variable.units, variable.long_name, variable.flags)
            for name, variable in DEPTH.variables.items()
            if variable.dims == ("depth",)
        },
    },
    ("well", "depth", "window", "start", "end"),
)

PROBLEM_COLUMNS = ("well", "stage", "where", "what", "remedy")
"""Columns of every stage's problems.csv: one row for whatever was rejected, with its reason."""

DATASETS = {
    "records": RECORDS,
    "states": STATES,
    "windows": WINDOWS,
    "spectra": SPECTRA,
    "mobility": MOBILITIES,
    "stacks": STACKS,
    "fits": FITS,
    "stack_fits": STACK_FITS,
    "joint": JOINT_FITS,
    "discrepancy": DISCREPANCIES,
    "examination": EXAMINATIONS,
    "depth": DEPTH,
    "fleet": FLEET,
}
