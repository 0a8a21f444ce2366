"""The options of plans: one table makes command-line arguments, problem files, the desk and docs.

:mod:`pathgene.host.options.table` holds the table. It imports nothing heavy, so that ``--help``
answers quickly.
"""
