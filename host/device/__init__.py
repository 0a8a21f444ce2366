"""Boards: URLs, the link, the chip's commands, and the host's copy of the chip's map."""
