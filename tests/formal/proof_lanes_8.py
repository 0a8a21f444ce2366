"""Eight lanes of the parallel checker together visit each cell of a segment exactly once."""

from tests.formal import proof_lanes
from tools.formal import Proof


class Together(proof_lanes.Together):
    """Proved for all time, by induction, as there, for 8 lanes on a map of 16 x 16 cells."""

    LANES, MAP_SIZE = 8, 16


PROOF = Proof(
    claim=Together,
    depth=4,
    reached=8,
    long=True,
    induction=4,
    faults=proof_lanes.PROOF.faults,
)
