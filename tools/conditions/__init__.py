"""Pairs of test vectors that show the effect of each condition on its decision (MC/DC).

coverage.py counts branches, and has no conditions. pymcdc, on PyPI, runs one file alone, outside of
pytest and of a package, and takes a chain of comparisons for one condition.

A decision is a whole Boolean expression: the test of ``if``, ``while``, ``x if y else z`` or a
comprehension, and any comparison, ``and``, ``or`` or ``not`` that is a value. Its conditions are
the operands of ``and``, ``or`` and ``not``, of ``&`` and ``|`` between comparisons, and the links
of a chain of comparisons. Assertions, and code outside of functions, are left out.

The criterion is unique-cause MC/DC with short circuits: a condition has a pair if two vectors that
tests produced differ in it and in the outcome, and no other condition that was evaluated in both
differs.
"""
