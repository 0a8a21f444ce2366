"""The genetic core: selection, crossover, mutation, population update and their control."""
