"""Every dataset's dimensions, dtypes, units and meaning, in one place; CF conventions where CF has one."""

from drillid.datasets.codes import Gate, Identifiability
from drillid.datasets.declaration import DatasetSchema, Variable, each
from drillid.datasets.measured import AT_FREQUENCIES, IN_WINDOWS, MOBILITY, STACKS, row_key
from drillid.datasets.measured import WINDOW_COORDINATES as WINDOW_COORDINATES
from drillid.physics.parameters import PARAMETERS


def _parameters(row: str) -> dict[str, Variable]:
    dims = (row, "parameter")
    return {
        "key": row_key(row),
        "parameter": Variable(("parameter",), "str", "", "parameter of the transmission-line model"),
        "parameter_": Variable(("parameter_",), "str", "", "second axis of the correlations"),
        "value": Variable(dims, "float64", "", "fitted value, SI"),
        "standard_error": Variable(dims, "float64", "", "standard error of the fitted value"),
        "interval_lower": Variable(dims, "float64", "", "lower end of the 95 % interval"),
        "interval_upper": Variable(dims, "float64", "", "upper end of the 95 % interval"),
        "status": Variable(dims, "int8", "", "how far the window determines the parameter", Identifiability),
        "at_bound": Variable(dims, "bool", "", "value lies at its physical bound: bounded on one side only"),
        "prior": Variable(dims, "float64", "", "value from the rig's data sheets; NaN where not given"),
        "prior_error": Variable(dims, "float64", "", "standard uncertainty of the value from the rig's data sheets"),
        "correlation": Variable(
            (row, "parameter", "parameter_"), "float64", "1", "correlation of the parameters' errors"
        ),
        "gain": Variable(("gain",), "str", "", "gain of the speed control"),
        "gain_value": Variable((row, "gain"), "float64", "", "gain fitted within its stated uncertainty, SI"),
        "chi2_per_dof": Variable((row,), "float64", "1", "chi-squared of the residuals per degree of freedom"),
        "residual_dof": Variable((row,), "float64", "1", "degrees of freedom of the residuals"),
        "fit_p_value": Variable((row,), "float64", "1", "p-value of chi-squared under the fitted model"),
        "mismatch": Variable(
            (row,),
            "float64",
            "1",
            "factor by which residuals exceed the noise; the part of this excess that is correlated over frequency is "
            "included in the standard errors",
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
    "Fit of all windows together: drive and pipe shared, damping and BHA as random walks in depth with jumps",
    {
        **IN_WINDOWS,
        "parameter": Variable(("parameter",), "str", "", "parameter of the transmission-line model"),
        "shared": Variable(("shared",), "str", "", "coordinate that is the same in all windows"),
        "random_walk": Variable(("random_walk",), "str", "", "parameter that follows a random walk in depth"),
        "value": Variable(_WP, "float64", "", "value, SI"),
        "standard_error": Variable(_WP, "float64", "", "standard error of the value"),
        "lower": Variable(_WP, "float64", "", "lower end of the 95 % band"),
        "upper": Variable(_WP, "float64", "", "upper end of the 95 % band"),
        **each(
            ("window",),
            weight=("1", "share of the window's information that was used"),
            agreement=("1", "p-value of the window's distance from the common fit"),
        ),
        "shared_value": Variable(("shared",), "float64", "", "shared value, SI"),
        "shared_error": Variable(("shared",), "float64", "", "standard error of the shared value"),
        "random_walk_step": Variable(
            ("random_walk",), "float64", "1", "root-mean-square change of the coordinate over 100 m"
        ),
        "change_parameter": Variable(("change",), "str", "", "parameter that jumps"),
        **each(
            ("change",),
            change_depth=("m", "most probable bit depth of the jump"),
            change_from=("m", "shallow end of the 95 % interval of that depth"),
            change_to=("m", "deep end of the 95 % interval of that depth"),
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
        "key": row_key("depth"),
        "window": Variable(("depth",), "int32", "", "number of the window in its well"),
        "start": Variable(("depth",), "datetime64[ns]", "", "first sample of the window"),
        "end": Variable(("depth",), "datetime64[ns]", "", "end of the window, exclusive"),
        "state": Variable(("state",), "str", "", "state of the rig"),
        "state_time": Variable(("depth", "state"), "float64", "s", "time in each state since the previous window"),
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
            critical_slope=("N m s rad-1", "decrease of bit torque with speed above which vibration grows"),
            critical_frequency=("Hz", "frequency of that vibration"),
            lowest_stable_speed=(
                "rad s-1",
                "speed below which a bit of the stated torque per weight sticks and slips; infinite where it does at "
                "every speed",
            ),
            present_proportional=("N m s rad-1", "proportional gain of the identified speed control"),
            present_integral=("N m rad-1", "integral gain of the identified speed control"),
            tuned_proportional=("N m s rad-1", "proportional gain of the speed control with the least bit vibration"),
            tuned_integral=("N m rad-1", "integral gain of the speed control with the least bit vibration"),
            tuned_vibration=(
                "1",
                "largest bit mobility with these gains, relative to that with the present gains; 0 where these are "
                "unstable",
            ),
        ),
        **{
            f"{name}_at_bound": Variable(
                ("depth",), "bool", "", f"{text}: at its physical bound, bounded on one side only"
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
        "flagged": Variable(
            ("depth",),
            "bool",
            "",
            "BHA damping or inertia is significantly above the level of its run, in the window or on both sides of it",
        ),
        "verdict": Variable(("depth",), "str", "", "what the simulation gets wrong, from the window's set"),
    },
    ("window", "start", "end"),
)

FLEET = DatasetSchema(
    "Identified drilling dynamics of the fleet, one row per window",
    {
        "well": Variable(("row",), "str", "", "name of the well"),
        **{
            name: Variable(("row",), variable.dtype, variable.units, variable.long_name, variable.flags)
            for name, variable in DEPTH.variables.items()
            if variable.dims == ("depth",) and name != "key"
        },
    },
    ("well", "depth", "window", "start", "end"),
)

_MODEL_TIME, _MODEL_SPAN = ("model", "time"), ("model", "span")
START_UPS = DatasetSchema(
    "A measured start of rotation beside its simulations",
    {
        "time": Variable(("time",), "float64", "s", "time since the first sample"),
        **each(
            ("time",),
            top_speed=("rad s-1", "measured speed of the top drive, which the simulations follow"),
            torque=("N m", "measured torque of the drive"),
            bit_slowest=("rad s-1", "least measured speed of the bit in each half second"),
            bit_fastest=("rad s-1", "greatest measured speed of the bit in each half second"),
        ),
        "model": Variable(("model",), "str", "", "model with which the start is simulated"),
        **each(
            _MODEL_TIME,
            simulated_torque=("N m", "simulated torque of the drive"),
            simulated_bit_speed=("rad s-1", "simulated speed of the bit as recorded, half-second statistics"),
        ),
        "span": Variable(("span",), "str", "", "part of the log: fitted to, or held out"),
        **each(
            ("span",), span_from=("s", "time at which the part begins"), span_to=("s", "time at which the part ends")
        ),
        **each(
            _MODEL_SPAN,
            torque_rms=("N m", "rms error of the torque, over friction of 98.5, 100 and 101.5 %"),
            bit_rms=("rad s-1", "rms error of the bit speed; NaN where it is not measured"),
        ),
        **each(
            ("model",),
            gain=(
                "1",
                "reduction of the held-out squared error, as a share of that of the preceding kept model",
            ),
            gain_low=("1", "lower end of the gain's 90 % interval, a one-sided 95 % limit"),
            gain_high=("1", "upper end of the gain's 90 % interval"),
        ),
        "kept": Variable(
            ("model",),
            "bool",
            "",
            "the model to predict with: the last whose gain has an interval above zero, else the description",
        ),
        "parameter": Variable(("parameter",), "str", "", "fitted parameter"),
        "value": Variable(("model", "parameter"), "float64", "", "its value, SI, the modulus in GPa"),
        "at_bound": Variable(("model", "parameter"), "bool", "", "the value lies at its bound"),
    },
)
