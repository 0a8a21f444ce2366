"""Formats of files, one file each: how pathgene writes a format, and how it reads it."""
