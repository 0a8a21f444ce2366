"""Developer tools: set-up, benches, proofs, mutation testing, generated documents."""
