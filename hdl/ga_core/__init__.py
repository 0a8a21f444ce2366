"""The paper core: selection, crossover, mutation, population update and their control."""
