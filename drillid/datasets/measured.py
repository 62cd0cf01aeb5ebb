"""Datasets of measurements: records, windows, spectra, mobility; and what all schemas share."""

from drillid.datasets.codes import Gate, RecordFlag, RigState
from drillid.datasets.declaration import DatasetSchema, Variable, each

MOBILITY = "rad N-1 m-1 s-1"
"""CF unit of a mobility."""
WINDOW_COORDINATES = ("window", "hole_depth", "start", "end")
"""Coordinates that identify a row's window in every dataset."""


def row_key(row: str) -> Variable:
    """The key of every row: rows with equal keys are equal."""
    return Variable((row,), "str", "", "hash of everything that the row comes from")


IN_WINDOWS = {
    "window": Variable(("window",), "int32", "", "number of the window in its well"),
    "hole_depth": Variable(("window",), "float64", "m", "mean measured depth of the hole"),
    "start": Variable(("window",), "datetime64[ns]", "", "first sample of the window"),
    "end": Variable(("window",), "datetime64[ns]", "", "end of the window, exclusive"),
}
AT_FREQUENCIES = {"frequency": Variable(("frequency",), "float64", "Hz", "frequency")}
WINDOW_FREQUENCY = ("window", "frequency")

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

LOGS = DatasetSchema(
    "Logs in a well's records, in order of time",
    {
        "log": Variable(("log",), "int16", "", "number of the log file, in order of time"),
        "file": Variable(("log",), "str", "", "name of the log file, with its folder where another has that name"),
        "first_sample": Variable(("log",), "int64", "", "index of its first sample in the records"),
        "samples": Variable(("log",), "int64", "", "number of its samples in the records"),
        "key": row_key("log"),
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
            standpipe_pressure=("Pa", "mean stand-pipe pressure"),
            sweep_amplitude=("N m", "root mean square of the injected sweep"),
            flagged_share=("1", "share of interpolated or replaced samples"),
        ),
        "first_sample": Variable(("window",), "int64", "", "index of the first sample in the records"),
        "samples": Variable(("window",), "int64", "", "number of samples"),
        "key": row_key("window"),
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
            WINDOW_FREQUENCY,
            sweep_power=("N2 m2", "mean squared amplitude of the sweep"),
            speed_power=("rad2 s-2", "mean squared amplitude of the speed"),
            speed_noise=("rad2 s-2", "variance of the speed's amplitude not due to the sweep, per average"),
            command_noise=("N2 m2", "variance of the torque command's amplitude not due to the sweep, per average"),
            sweep_rounding=("N2 m2", "mean squared amplitude of the quantisation error of a periodic sweep's record"),
        ),
        **each(
            WINDOW_FREQUENCY,
            "complex128",
            cross_speed=("N m rad s-1", "cross spectrum of speed and sweep"),
            cross_command=("N2 m2", "cross spectrum of torque command and sweep"),
            cross_noise=("N m rad s-1", "covariance of speed and torque command not due to the sweep, per average"),
        ),
        "averages": Variable(WINDOW_FREQUENCY, "float64", "1", "equivalent number of independent averages"),
        "degrees_of_freedom": Variable(
            WINDOW_FREQUENCY, "float64", "1", "complex degrees of freedom of the noise variance"
        ),
        "key": row_key("window"),
        "sweep_period": Variable(("window",), "float64", "s", "period of the sweep; 0 where it is not periodic"),
        "band": Variable(("band",), "float64", "Hz", "lower edge of the band"),
        "band_end": Variable(("band",), "float64", "Hz", "upper edge of the band"),
        **each(
            ("window", "band"),
            response_level=("rad s-1", "root mean square of the speed's response in the band"),
            noise_level=("rad s-1", "root mean square of the noise of the mean of all periods"),
            even_level=("rad s-1", "root mean square of distortion of even order, beyond the noise"),
            odd_level=("rad s-1", "root mean square of distortion of odd order, beyond the noise"),
        ),
        "even_detected": Variable(("window", "band"), "bool", "", "distortion of even order is significant"),
        "odd_detected": Variable(("window", "band"), "bool", "", "distortion of odd order is significant"),
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
        "key": row_key(row),
        "command_mobility": Variable(
            dims, "complex128", MOBILITY, "command mobility: top-drive speed per injected torque"
        ),
        "command_mobility_variance": Variable(
            dims, "float64", f"({MOBILITY})2", "variance of the complex command mobility"
        ),
        "averages": Variable(dims, "float64", "1", "equivalent number of independent averages"),
        "degrees_of_freedom": Variable(dims, "float64", "1", "complex degrees of freedom of the variance"),
        "coherence": Variable(dims, "float64", "1", "squared coherence of speed and sweep"),
        "coherence_minimum": Variable(dims, "float64", "1", "smallest mean coherence of a band that passes the gate"),
        "coherence_maximum": Variable(dims, "float64", "1", "largest coherence that passes the gate"),
        "gate": Variable(dims, "int8", "", "why the frequency is used or left out", Gate),
    }


_LOOP = {
    **each(
        WINDOW_FREQUENCY,
        "complex128",
        torque_mobility=(MOBILITY, "top-drive speed per torque command, free of the controller"),
        control_response=("N m s rad-1", "reduction of torque command per top-drive speed: controller and its filters"),
    ),
    **each(
        WINDOW_FREQUENCY,
        torque_mobility_variance=(f"({MOBILITY})2", "variance of the complex torque mobility"),
        control_response_variance=("(N m s rad-1)2", "variance of the complex control response"),
        control_response_rounding=(
            "(N m s rad-1)2",
            "variance due to the sweep's quantisation, the same error in all windows",
        ),
    ),
    **each(
        ("window",),
        channel_offset=("s", "time by which the recorded torque command lags the recorded sweep"),
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
        "agreement_p_value": Variable(("stack",), "float64", "1", "p-value of the disagreement between the windows"),
        "windows": Variable(("stack",), "int32", "", "number of windows in the stack"),
        **AT_FREQUENCIES,
        **_mobility("stack"),
    },
    ("hole_depth", "first_window", "last_window"),
)
