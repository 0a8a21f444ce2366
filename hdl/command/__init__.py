"""What the receiving unit does with the payload of each command, one unit per kind."""
