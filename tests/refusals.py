"""Commands that a chip refuses and its replies, for the gateware and its model."""

from hdl.protocol import Command, LinkMode, Status, pack_paths, start_request


__all__ = ["refusals"]


def refusals(config, order):
    """Return command, payload and status of each refusal by a chip with a population of 8.

    ``order`` is a valid ranking.
    """
    layout = start_request(config)
    good = {"seed": 0x0123456789ABCDEF, "x": 0, "y": 0, "altitude": 0, "avoid_ground": 0}
    start = layout.pack(**good)
    paths = [[1, 2], [1, 2]]
    return [
        (0, b"", Status.UNKNOWN_COMMAND),
        (200, b"abc", Status.UNKNOWN_COMMAND),
        (Command.INFO, b"", Status.UNKNOWN_COMMAND),
        (Command.STATUS, b"\0", Status.BAD_LENGTH),
        (Command.COUNTERS, b"\0", Status.BAD_LENGTH),
        (Command.CLEAR, b"abc", Status.BAD_LENGTH),
        (Command.START, b"", Status.BAD_LENGTH),
        (Command.START, start[:-1], Status.BAD_LENGTH),
        (Command.START, start + b"\0", Status.BAD_LENGTH),
        (Command.START, start * 9, Status.BAD_LENGTH),
        (Command.START, layout.pack(**good | {"x": config.map_size}), Status.BAD_VALUE),
        (Command.START, layout.pack(**good | {"y": config.map_size}), Status.BAD_VALUE),
        (
            Command.START,
            layout.pack(**good | {"altitude": config.blocked_altitude}),
            Status.BAD_VALUE,
        ),
        (Command.READ, b"\0", Status.BAD_LENGTH),
        (Command.READ, b"\0\1\0", Status.BAD_LENGTH),
        (Command.READ, b"\0\0", Status.BAD_VALUE),
        (Command.READ, b"\7\2", Status.BAD_VALUE),
        (Command.READ, b"\xff\xff", Status.BAD_VALUE),
        (Command.WRITE, b"", Status.BAD_LENGTH),
        (Command.WRITE, b"\0", Status.BAD_LENGTH),
        (Command.WRITE, b"\0\1", Status.BAD_LENGTH),
        (Command.WRITE, b"\0\1\0\0", Status.BAD_LENGTH),
        (Command.WRITE, b"\0\1\0", Status.BAD_VALUE),  # No last waypoint.
        (Command.WRITE, b"\0" + pack_paths(config, [[1]]), Status.BAD_VALUE),
        (
            Command.WRITE,
            b"\0" + pack_paths(config, [[1] * (config.max_waypoints + 1)]),
            Status.BAD_VALUE,
        ),
        (Command.WRITE, b"\7" + pack_paths(config, paths), Status.BAD_VALUE),
        (Command.WRITE, b"\x08" + pack_paths(config, paths[:1]), Status.BAD_VALUE),
        (Command.GENERATE, b"", Status.BAD_LENGTH),
        (Command.GENERATE, b"\3", Status.BAD_VALUE),
        (Command.GENERATE, b"\0\0", Status.BAD_LENGTH),
        (Command.GENERATE, bytes((LinkMode.RANK, *order[:-1])), Status.BAD_LENGTH),
        (Command.GENERATE, bytes((LinkMode.RANK, *order, 0, 1)), Status.BAD_LENGTH),
        (Command.GENERATE, bytes((LinkMode.RECIPE, *order[:-1], 8)), Status.BAD_VALUE),
        (Command.GENERATE, bytes((LinkMode.RECIPE, *order[:-1], order[0])), Status.BAD_VALUE),
    ]
