"""How parameters, figures and gates are named for readers: units people say, titles, captions."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """A parameter as readers see it.

    name, symbol, index : words, sign and its subscript
    unit : unit that people say
    factor : number that takes SI values to that unit
    decimals : digits behind the point worth printing
    """

    name: str
    symbol: str
    index: str
    unit: str
    factor: float = 1.0
    decimals: int = 0

    @property
    def axis_label(self) -> str:
        """Name over sign and unit, in matplotlib's mathtext."""
        sign = f"${self.symbol}_{{{self.index}}}$" if self.index else self.symbol
        return f"{self.name}\n{sign} [{self.unit}]"


QUANTITIES = {
    "kappa": Quantity("Mud and wall damping", "κ", "", "N s/m⁴"),
    "delta": Quantity("Internal damping", "δ", "", "MN s/m²", 1e-6),
    "length": Quantity("Pipe length", "L", "", "m"),
    "polar_moment": Quantity("Pipe polar moment", "IP", "", "cm⁴", 1e8),
    "delay": Quantity("Drive delay", "T", "d", "ms", 1e3, 2),
    "inertia_td": Quantity("Top-drive inertia", "J", "td", "kg m²", 1.0, 1),
    "damping_bha": Quantity("BHA damping", "Y", "bha", "N m s/rad"),
    "inertia_bha": Quantity("BHA inertia", "J", "bha", "kg m²"),
}
"""The eight parameters, in the order of `drillid.physics.parameters.PARAMETERS`."""

LENGTH_LESS_DEPTH = "Pipe length L less\nthat by depth [m]"
"""Pipe length less bit depth less collars: the length itself only repeats the depth."""

RPM_PER_KILONEWTON_METRE = 1e3 * 30 / 3.141592653589793
"""Takes rad/s per N m to rpm per kN m."""

_IMAGE = (
    "Depth runs downwards; the dark bars on the left are the segments that windows measured, "
    "and up to one stand beside them is filled in."
)


@dataclass(frozen=True)
class FigureText:
    """What one figure is called, and how to read it."""

    title: str
    caption: str


FIGURES = {
    "parameters": FigureText(
        "Parameters against depth",
        "Green: value and 95 % band from all windows together, with drive and pipe shared; red lines: depths where the "
        "parameter jumps. Dark: every window on its own, with 95 % bars. Blue: the rig's data sheets with twice their "
        "tolerance. Pipe length is drawn less bit depth less collars. Triangles: the value lies at its physical bound, "
        "so only one side is known. Hollow grey: fit not accepted.",
    ),
    "anomaly": FigureText(
        "What stands out",
        "BHA damping and inertia in standard deviations from the level of their run. Orange: windows that stand out "
        "upwards in either, and the least that can flag one (more in a run that scatters). Right: how well the model "
        "explains the data of each window.",
    ),
    "verdicts": FigureText(
        "What the simulation gets wrong",
        "Every verdict of the discovery engine over its depths, its probability, and what the extended model gains on "
        "windows that it was not fitted to, with 90 % intervals. Red: named causes; violet: something is wrong that "
        "the catalogue does not hold; grey: none.",
    ),
    "evidence": FigureText(
        "Evidence for every cause",
        "Log Bayes factor of each cause of the catalogue, and of something unknown: a disturbance at a port, or "
        "data sheets that do not fit; for every set of windows. Above zero the data speak for it, and 5 is strong; "
        "beyond 10 the axis is logarithmic. Bars end at −10.",
    ),
    "distinguishability": FigureText(
        "Which causes these data can tell apart",
        "Left: how many standard deviations a cause of its usual size (row) stays from the best that another one "
        "(column) can do, past all that is not known; below 3 the two cannot be told apart. Right: the smallest size "
        "that shows; left of the blue line the usual size shows. Both hold before anything is looked for.",
    ),
    "model_residuals": FigureText(
        "What the models of the sets leave over",
        "Measured less modelled mobility in standard deviations, with one model for each set of windows, before and "
        f"after the named cause is added. Right: a right model stays at 1. {_IMAGE}",
    ),
    "held_out": FigureText(
        "A window that the models have not seen",
        "Base and extended model are fitted to the other windows of the set; only damping and inertia that every "
        "window has of its own are fitted here, by both alike. Below: the speed that the sweep drives, in the sweep's "
        "band, where it is largest, with the 95 % band of the measured mean.",
    ),
    "reflectogram": FigureText(
        "Where along the string",
        "Measured less modelled reflection of waves that run down the string, against the distance from which it "
        "comes back, over all windows of the set. Grey: what noise alone passes nowhere, at the stated error rate. "
        "A cause above the string shows at no place of its own.",
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
        "Frequencies that the coherence gate leaves out are missing above and grey crosses in the coherence.",
    ),
    "command_mobility_fitted": FigureText(
        "Identified command and bit mobility",
        "The fitted models of the same windows and of their stack; grey dots are measured, by the stack or else by the "
        "middle window. Below: what the bit would do with the top drive clamped, which shows the string alone.",
    ),
    "command_mobility_depth": FigureText(
        "Command mobility against depth",
        f"Measured on the left, identified on the right. Grey: left out by the coherence gate. {_IMAGE}",
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
        "What the fits leave over",
        "Measured less fitted command mobility in standard deviations. A right model and a right noise estimate leave "
        f"structureless noise that follows the normal distribution. {_IMAGE}",
    ),
}
"""Every figure of a well, in the order of the report."""
