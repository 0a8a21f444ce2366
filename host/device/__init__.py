"""Boards: URLs, the link, the chip's commands, and the copy of the chip's map."""
