"""What the schemas of window by window datasets share."""

from drillid.declaration import Variable

MOBILITY = "rad N-1 m-1 s-1"
"""CF unit of a mobility."""
WINDOW_COORDINATES = ("window", "hole_depth", "start", "end")
"""Coordinates that tell in every dataset which window a row is."""
IN_WINDOWS = {
    "window": Variable(("window",), "int32", "", "number of the window in its well"),
    "hole_depth": Variable(("window",), "float64", "m", "mean measured depth of the hole"),
    "start": Variable(("window",), "datetime64[ns]", "", "first sample of the window"),
    "end": Variable(("window",), "datetime64[ns]", "", "end of the window, exclusive"),
}
AT_FREQUENCIES = {"frequency": Variable(("frequency",), "float64", "Hz", "frequency")}
WINDOW_FREQUENCY = ("window", "frequency")
