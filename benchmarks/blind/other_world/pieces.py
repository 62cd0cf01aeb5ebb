"""Changes of a string between two depths."""

from collections.abc import Callable

from benchmarks.blind.hidden import altered
from benchmarks.blind.other_world.rig import Piece

Change = Callable[[Piece], Piece]
_NEGLIGIBLE = 1e-6
"""m."""


def cut(string: tuple[Piece, ...], depth: float) -> tuple[tuple[Piece, ...], tuple[Piece, ...]]:
    """The parts of a string above and below a depth (m)."""
    above: list[Piece] = []
    for number, piece in enumerate(string):
        if depth <= _NEGLIGIBLE:
            return tuple(above), string[number:]
        if depth < piece.length - _NEGLIGIBLE:
            upper = altered(piece, length=depth, inertia_below=0.0, damping_below=0.0)
            return (*above, upper), (altered(piece, length=piece.length - depth), *string[number + 1 :])
        above.append(piece)
        depth -= piece.length
    return tuple(above), ()


def changed(string: tuple[Piece, ...], begin: float, end: float, change: Change) -> tuple[Piece, ...]:
    """The string with other pieces between two depths (m)."""
    above, rest = cut(string, begin)
    middle, below = cut(rest, end - max(begin, 0.0))
    return (*above, *(change(piece) for piece in middle), *below)


def shortened(string: tuple[Piece, ...], length: float) -> tuple[Piece, ...]:
    """The string without so much (m) of its lowest pieces."""
    return cut(string, sum(piece.length for piece in string) - length)[0]
