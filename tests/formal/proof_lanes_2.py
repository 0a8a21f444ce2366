"""Two lanes of the parallel checker together visit each cell of a segment exactly once."""

from tests.formal import proof_lanes
from tools.formal import Proof


class Together(proof_lanes.Together):
    """Proved for all time, by induction, as there, for 2 lanes on a map of 8 x 8 cells."""

    LANES, MAP_SIZE = 2, 8


PROOF = Proof(
    claim=Together,
    depth=6,
    reached=8,
    long=True,
    induction=6,
    faults=proof_lanes.PROOF.faults,
)
