"""The control unit of a chip that only checks paths always returns to listening."""

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.control import Control
from tests.formal import proof_control
from tools.formal import Proof


class Returns(proof_control.Returns):
    """Proved for all time, by induction, as there, for a chip without a genetic core.

    After the receiving unit comes the check, if the command asks for one, and the answer; the state
    is LISTEN again at most ``3 * limit`` cycles after it has left LISTEN.
    """

    CONFIG = Config(core="none", checker=CheckerBuild.TWO_TIER, lanes=1)
    MOST_UNITS = 3


PROOF = Proof(
    claim=Returns,
    depth=2,
    reached=10,
    induction=2,
    faults={
        "the answer does not end": (
            Control,
            ("LISTEN] = self.transmit_done", "LISTEN] = self.transmit_done & self.line_busy"),
        ),
        "no answer after a check": (
            Control,
            ("[ChipState.CHECK, ChipState.TRANSMIT]", "[ChipState.CHECK, ChipState.LISTEN]"),
        ),
        "a check that nobody asked for": (
            Control,
            ("= received & self.check", "= received"),
        ),
        "two units on": (
            Control,
            (
                "self.check_on.eq(on.check)",
                "self.check_on.eq(on.check | self.pending)",
            ),
        ),
    },
)
