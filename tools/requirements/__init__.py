"""Requirements: sentences of the pages, each with its unit, its test and a planted fault."""
