"""Names of parameters and figures for readers: usual units, titles, captions."""

from dataclasses import dataclass


@dataclass(frozen=True)
class DisplayedParameter:
    """A parameter as displayed to readers.

    name, symbol, index : words, symbol and its subscript
    unit : usual unit
    factor : conversion of SI values to that unit
    decimals : significant decimal places
    """

    name: str
    symbol: str
    index: str
    unit: str
    factor: float = 1.0
    decimals: int = 0

    @property
    def axis_label(self) -> str:
        """Name, then symbol and unit, in matplotlib's mathtext."""
        symbol = f"${self.symbol}_{{{self.index}}}$" if self.index else self.symbol
        return f"{self.name}\n{symbol} [{self.unit}]"


DISPLAYED_PARAMETERS = {
    "kappa": DisplayedParameter("Mud and wall damping", "κ", "", "N s/m⁴"),
    "delta": DisplayedParameter("Internal damping", "δ", "", "MN s/m²", 1e-6),
    "length": DisplayedParameter("Pipe length", "L", "", "m"),
    "polar_moment": DisplayedParameter("Pipe polar moment", "IP", "", "cm⁴", 1e8),
    "delay": DisplayedParameter("Drive delay", "T", "d", "ms", 1e3, 2),
    "inertia_td": DisplayedParameter("Top-drive inertia", "J", "td", "kg m²", 1.0, 1),
    "damping_bha": DisplayedParameter("BHA damping", "Y", "bha", "N m s/rad"),
    "inertia_bha": DisplayedParameter("BHA inertia", "J", "bha", "kg m²"),
}
"""The eight parameters, in the order of `drillid.physics.parameters.PARAMETERS`."""

LENGTH_LESS_DEPTH = "Pipe length L less\nthat by depth [m]"
"""Pipe length minus (bit depth less collars): the length itself only repeats the depth."""

RPM_PER_KILONEWTON_METRE = 1e3 * 30 / 3.141592653589793
"""Converts rad/s per N m to rpm per kN m."""

_IMAGE = (
    "Depth increases downwards; the dark bars on the left are the depths of the windows, "
    "and gaps of up to one stand between them are filled."
)


@dataclass(frozen=True)
class FigureText:
    """Title of a figure, and how to read it."""

    title: str
    caption: str


FIGURES = {
    "parameters": FigureText(
        "Parameters against depth",
        "Green: value and 95 % band from all windows together, with drive and pipe shared; red lines: depths where the "
        "parameter jumps. Dark: every window on its own, with 95 % bars. Blue: the rig's data sheets with twice their "
        "tolerance. Pipe length is drawn minus that by depth. Triangles: the value lies at its physical bound, so it "
        "is bounded on one side only. Hollow grey: fit not accepted.",
    ),
    "anomaly": FigureText(
        "What stands out",
        "BHA damping and inertia in standard deviations from the level of their run. Orange: windows with a "
        "significant rise in either, or in their neighbours on both sides, and the smallest deviation that is flagged "
        "(larger in a run with more scatter). "
        "Right: goodness of fit, and the p-value below which normality or whiteness fails.",
    ),
    "verdicts": FigureText(
        "What the simulation gets wrong",
        "Every verdict of the discovery engine over its depths, its probability, and the predictive gain of the "
        "extended model on windows that it was not fitted to, with 90 % intervals. Red: named causes; violet: a cause "
        "outside the catalogue; grey: none.",
    ),
    "evidence": FigureText(
        "Evidence for every cause",
        "Log Bayes factor of each cause of the catalogue, and of an unknown one: a disturbance at a port or "
        "along the pipe, or data sheets that do not fit; for the three most informative sets of windows. Above zero "
        "the data favour it, and 5 is strong; beyond 10 the axis is logarithmic. Bars end at −10. A cause that a "
        "channel cannot show was not tested on it.",
    ),
    "distinguishability": FigureText(
        "Which causes these data distinguish",
        "Left: distance, in standard deviations, of a cause of its usual size (row) from the best fit by another one "
        "(column), with all other unknowns fitted; below 3.3 the two are indistinguishable. Right: the smallest "
        "detectable size; left of the blue line the usual size is detectable. Both apply before any cause is added.",
    ),
    "model_residuals": FigureText(
        "Residuals of the models of the sets",
        "Measured less modelled mobility in standard deviations, with one model for each set of windows, before and "
        f"after the named cause is added. Right: a correct model has a mean square of 1. {_IMAGE}",
    ),
    "held_out": FigureText(
        "A held-out window",
        "Base and extended model are fitted to the other windows of the set; only the damping and inertia that differ "
        "from window to window are fitted here, in both models. Below: the speed response to the sweep, in the sweep's "
        "band, where it is largest, with the 95 % band of the measured mean.",
    ),
    "reflectogram": FigureText(
        "Where along the string",
        "Measured less modelled reflection of waves that travel down the string, against the distance at which they "
        "are reflected, over all windows of the set. Grey: limit that noise alone exceeds anywhere only with "
        "the stated error rate. A cause above the string has no position along it.",
    ),
    "spectrograms": FigureText(
        "Torque command and top-drive speed",
        "Power over time and frequency in the middle window. The injected sweeps are slanted lines; the string's "
        "modes, excited by the bit, are horizontal lines in the speed. Ticks on the right: modes of the identified "
        "model.",
    ),
    "command_mobility_measured": FigureText(
        "Measured command mobility",
        "Top-drive speed per injected torque of successive windows, and their stack with its 95 % band. "
        "Frequencies that the coherence gate rejects are missing above and grey crosses in the coherence.",
    ),
    "command_mobility_fitted": FigureText(
        "Identified command and bit mobility",
        "The fitted models of the same windows and of their stack; grey dots are measurements, of the stack or, "
        "without one, of the middle window. Below: the bit mobility with the top drive clamped, which is that of the "
        "string alone.",
    ),
    "command_mobility_depth": FigureText(
        "Command mobility against depth",
        f"Measured on the left, identified on the right. Grey: rejected by the coherence gate. {_IMAGE}",
    ),
    "bit_step_stiff": FigureText(
        "Bit speed after a torque step at the bit, stiff top drive",
        f"Echoes between a clamped top drive and the bit; how slowly they fade shows the string's damping. {_IMAGE}",
    ),
    "bit_step_controlled": FigureText(
        "Bit speed after a torque step at the bit, top drive as controlled",
        f"The same with the rig's own speed control, in the same colours. {_IMAGE}",
    ),
    "bit_mobility_stiff": FigureText(
        "Bit mobility, stiff top drive",
        "Bit speed per torque on the bit over frequency with the top drive clamped: bright lines are the string's "
        f"modes. {_IMAGE}",
    ),
    "bit_mobility_controlled": FigureText(
        "Bit mobility, top drive as controlled",
        f"The same with the rig's own speed control, in the same colours: it acts on the lowest modes. {_IMAGE}",
    ),
    "residuals": FigureText(
        "Residuals of the fits",
        "Measured less fitted command mobility in standard deviations. A correct model and a correct noise estimate "
        f"leave white noise that follows the normal distribution. {_IMAGE}",
    ),
}
"""Every figure of a well, in the order of the report."""


def share(part: float, whole: float) -> str:
    """A share in percent; never rounded to 0 or 100 % unless exact, and a dash where the whole is nothing."""
    if not whole:
        return "–"
    percent = 100 * part / whole
    return "> 99 %" if 99 < percent < 100 else "< 1 %" if 0 < percent < 1 else f"{percent:.0f} %"
