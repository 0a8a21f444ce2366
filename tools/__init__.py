"""Developer tools: set-up, benches, proofs, mutation testing, generation of documents."""
