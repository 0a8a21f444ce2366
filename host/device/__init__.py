"""Everything that talks to a board: link, chip, board URLs, and the copy of the chip's map."""
