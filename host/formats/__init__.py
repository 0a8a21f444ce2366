"""File formats, one module each: how pathgene writes and reads the format."""
