"""The COBS encoder sends the code of each frame by its definition, at its real sizes."""

from tests.formal import proof_cobs_encoder
from tools.formal import Proof


class Encoder(proof_cobs_encoder.Encoder):
    """Proved for all time, by induction, as there, with a full block of 255 and 512 bytes."""

    FULL, DEPTH = 0xFF, 512
    #: With as many rows, the solver is slow to find an example of more than a frame taken.
    SHOWN = False


# All further faults show only after a full block.
SHOWN = ("the code is written over the next byte", "no delimiter")

PROOF = Proof(
    claim=Encoder,
    depth=3,
    reached=9,
    long=True,
    induction=3,
    faults={name: proof_cobs_encoder.PROOF.faults[name] for name in SHOWN},
)
