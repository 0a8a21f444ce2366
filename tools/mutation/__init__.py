"""Mutation testing of the gateware: sites, alterations, ordered tests, equivalence checks."""
