"""Mutation testing of the gateware: sites, alterations, tests in order, and proofs of equality."""
