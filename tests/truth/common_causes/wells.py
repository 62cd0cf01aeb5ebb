"""Wells of one rig whose likelihoods are drawn from the model of the hierarchy itself."""

import numpy as np

from drillid.arrays import Floats
from drillid.common_causes.pooling import SetStatistics
from drillid.discrepancy.inference.shared_likelihood import RIG, candidate_labels, held_sizes, shared_candidates

ROWS = 60
CANDIDATES = shared_candidates()
LAG = candidate_labels().index("drive_lag")
SCALE = candidate_labels().index("speed_scale")
TOLERANCE = 0.5


def rows_of(generator: np.random.Generator, error: float) -> tuple[Floats, Floats, Floats]:
    """Responses of one well to its rig's coordinates (rows, R), and to each cause at its usual size: their part in
    proportion to the size and to its square, (rows, C); a lag of usual size is known to an error.
    """
    straight = generator.standard_normal((ROWS, len(CANDIDATES)))
    bent = 0.1 * generator.standard_normal((ROWS, len(CANDIDATES)))
    rig = generator.standard_normal((ROWS, RIG.size))
    scale = CANDIDATES[LAG].cause.size.typical / error / np.sqrt(ROWS)
    return scale * rig, scale * straight, scale * bent


def fleet(
    seed: int, wells: int, sizes: dict[int, Floats] | None = None, error: float = 0.01, rig: Floats | None = None
) -> list[SetStatistics]:
    """Wells of one rig with causes of given sizes, (wells,); the data sheets err by their tolerance, in all alike."""
    generator = np.random.default_rng(seed)
    rig = TOLERANCE * generator.standard_normal(RIG.size) if rig is None else rig
    held = np.stack([held_sizes(each.cause.size) for each in CANDIDATES])
    typical = np.array([each.cause.size.typical for each in CANDIDATES])
    found = []
    for well in range(wells):
        slopes, straight, bent = rows_of(generator, error)
        measured = slopes @ rig + generator.standard_normal(ROWS)
        for candidate, size in (sizes or {}).items():
            share = size[well] / typical[candidate]
            measured += straight[:, candidate] * share + bent[:, candidate] * share**2
        share = held / typical[:, None]
        effects = straight[:, :, None] * share + bent[:, :, None] * share**2
        rest = measured[:, None, None] - effects
        matrix = slopes.T @ slopes
        # the well's own fit, about which the likelihood is kept
        place = np.linalg.solve(matrix, slopes.T @ rest.reshape(ROWS, -1)).reshape(RIG.size, *held.shape)
        rest = rest - np.einsum("xr,rcs->xcs", slopes, place)
        value, score = -0.5 * np.sum(rest**2, axis=0), np.einsum("xr,xcs->csr", slopes, rest)
        ends = np.array([[0, -1] if each.cause.size.low < 0 else [1, -1] for each in CANDIDATES])
        changes = np.take_along_axis(effects, ends[None], axis=2).reshape(ROWS, -1)
        both = np.concatenate([slopes, changes], axis=1)
        directions = both.T @ both
        information = np.broadcast_to(matrix, (*held.shape, RIG.size, RIG.size))
        found.append(
            SetStatistics(
                well=f"W{well}",
                rig="R",
                prior_error=np.full(RIG.size, TOLERANCE),
                sizes=held,
                coordinates=np.moveaxis(place, 0, -1),
                value=np.stack([value, np.zeros_like(value)]),
                score=np.stack([score, np.zeros_like(score)]),
                information=np.stack([information, np.zeros_like(information)]),
                directions=np.stack([directions, np.zeros_like(directions)]),
                control_common=0.0,
                windows=1,
                temper=1.0,
            )
        )
    return found
