"""The proofs of this folder hold, and notice the planted faults."""

import pytest

from pathgene.hdl.primitives.buffers import SkidBuffer
from tools.formal import Proof, altered, check, main, proofs


#: Proofs of seconds. The same claims without induction, and simulations of the units, notice most
#: faults sooner.
COSTLY = {
    ("cobs_encoder", "induction"),
    ("control", "induction"),
    ("receiver", "induction"),
    ("run_control", "holds"),
    ("shape_drawer", "holds"),
    ("sorter", "holds"),
}


#: Faults that take seconds; each proof notices other faults in CI.
COSTLY_FAULTS = {
    ("run_control", "cycles start again"),
    ("run_control", "what is collected stays pending"),
    ("sorter", "one too many drops the worst although it is worse"),
}


def marks(name, proof, what):
    if proof.is_long(what) or (name, what) in COSTLY_FAULTS:
        return [pytest.mark.long]
    return [pytest.mark.ci] if what in proof.faults or (name, what) in COSTLY else []


CHECKS = [
    pytest.param(
        name,
        what,
        id=f"{name}-{what}",
        marks=marks(name, proof, what),
    )
    for name, proof in proofs().items()
    for what in proof.checks
]


@pytest.mark.parametrize(("name", "what"), CHECKS)
def test_proof(name, what):
    check(name, proofs()[name], what)


def test_a_claim_that_does_not_hold_is_refuted():
    proof = proofs()["skid"]
    ((_, *changes), *_) = proof.faults.values()

    def claim(unit):
        return proof.claim(lambda of: unit(of, *changes))

    wrong = Proof(claim=claim, depth=proof.depth, faults=proof.faults)
    with pytest.raises(AssertionError, match="holds fails"):
        check("skid-wrong", wrong, "holds")


def test_a_fault_that_breaks_nothing_is_told():
    harmless = {"none": (SkidBuffer, ("empty.eq(1)", "empty.eq(1 | empty)"))}
    proof = Proof(claim=proofs()["skid"].claim, depth=4, faults=harmless)
    with pytest.raises(AssertionError, match="'none' is not noticed"):
        check("skid-harmless", proof, "none")


def test_proofs_that_are_incomplete_are_refused():
    with pytest.raises(ValueError, match=r"^A proof must have at least one fault$"):
        Proof(claim=proofs()["skid"].claim, depth=4, faults={})
    with pytest.raises(ValueError, match=r"^Long checks must be checks of the proof$"):
        Proof(
            claim=proofs()["skid"].claim, depth=4, faults=proofs()["skid"].faults, long=("nothing",)
        )
    with pytest.raises(ValueError, match=r"^Depth must be at least the length of the induction$"):
        Proof(claim=proofs()["skid"].claim, depth=1, induction=2, faults=proofs()["skid"].faults)


def test_only_text_that_occurs_once_is_altered():
    with pytest.raises(
        ValueError, match=r"^'nothing like it' must occur once in pathgene\.hdl\.\S+, not 0 times$"
    ):
        altered(SkidBuffer, ("nothing like it", ""))
    with pytest.raises(
        ValueError, match=r"^'m\.d\.sync' must occur once in pathgene\.hdl\.\S+, not [2-9] times$"
    ):
        altered(SkidBuffer, ("m.d.sync", ""))


def test_an_unknown_proof_is_named(capsys):
    assert main(["--proof", "everything"]) == 2
    assert "No proof 'everything'" in capsys.readouterr().err
