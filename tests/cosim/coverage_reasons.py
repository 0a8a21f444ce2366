"""Points of units below the bounds of coverage that the sessions do not reach, by chip and unit."""

_COUNTERS = "upper bits of counters of 32 bits, which would take billions of cycles, bytes or paths"
_FULL = "a full buffer, because the reader always takes a word; `tests/unit/primitives` fills it"
_LONG_CODE = (
    "a block of 254 bytes without zero, longer than this chip's frames, and a sender that waits; "
    "`tests/unit/link/test_cobs.py` has both"
)
_WAITS = "a line that lets a checksum wait; `tests/unit/link/test_frame.py` does"
_PADDING = "the padding of the history, which is constant"
_TABLE = "the table, which is constant"
_FRAMING = (
    "a bad stop bit, which the simulated line never sends; `tests/unit/link/test_uart.py` does"
)
_SMALL = "upper bits of cycles, cells and reads of a check, too large for 16 x 16 cells"
_ROWS = "rows of the memory that two runs on one map do not write"
_PROBLEM = "bits that the few problems of these sessions share, such as figures of the aircraft"
_LARGE = "upper bits of products, roots and lengths, larger than a map of 32 x 32 cells needs"
_RUNS = "upper bits of limits and counts of a run, which these short runs do not use"

REASONS = {
    "planner core": {
        "AddSubtract": "the sum in the first digit of roots and quotients, which is always a "
        "difference, and upper bits that a map of 32 x 32 cells does not need",
        "ArcMeasurer": _LARGE,
        "BestReader": "upper bits of keys, and a reply that waits after its last waypoint",
        "BlockMap": _ROWS,
        "BlockMemory": _ROWS,
        "Chip": _COUNTERS,
        "CobsEncoder": _LONG_CODE,
        "Control": _COUNTERS,
        "FrameTransmitter": _WAITS,
        "KeyMaker": "values above 2^25 and the saturation of a key, too large for this map",
        "Line": _COUNTERS,
        "Memo": "tags of segments that two runs do not walk",
        "MemoryDelay": _ROWS,
        "Multiplier": _LARGE,
        "NearestCorner": _PROBLEM,
        "OneHotSequencer": _PADDING,
        "PathEvaluator": _PROBLEM,
        "PathPricer": _LARGE,
        "PathReducer": "upper bits of the number of cells in the ground",
        "PathStore": _ROWS,
        "PenaltyCounter": _LARGE,
        "PiecePricer": _LARGE,
        "PlannerCore": _PROBLEM,
        "PointLauncher": "entries and exits, which few of these problems have",
        "PopulationMemory": _ROWS,
        "Ranking": _ROWS,
        "Reciprocals": _TABLE,
        "Relaxer": _PROBLEM,
        "ReplyTransmitter": _COUNTERS,
        "ReplyWords": _COUNTERS,
        "ResultQueue": _ROWS,
        "Route": "places of routes, which have one memory row for each corner of the map",
        "RunControl": _RUNS,
        "RunLimits": _RUNS,
        "RunStatus": _RUNS,
        "Scorer": _PROBLEM,
        "SeedSource": _PROBLEM,
        "Seeder": _LARGE,
        "SkidBuffer": _FULL,
        "SlopeComparator": _PROBLEM,
        "Sorter": _ROWS,
        "StepConstants": _PROBLEM,
        "StepPricer": _PROBLEM,
        "StreamRegister": _FULL,
        "UartReceiver": _FRAMING,
        "Wavefront": "costs of corners that few problems reach, one memory row each",
        "WideMultiplier": _LARGE,
    },
    "paper core": {
        "BlockMemory": "altitudes of the map that few uploads have changed",
        "CheckController": _COUNTERS,
        "Checker": _SMALL,
        "Chip": _COUNTERS,
        "Chromosome": "rows of the memory that a path of at most five waypoints does not use",
        "CobsEncoder": _LONG_CODE,
        "Control": _COUNTERS,
        "FrameTransmitter": _WAITS,
        "Line": _COUNTERS,
        "OneHotSequencer": _PADDING,
        "ReadCrossbar": "the alternative of a condition that is constant",
        "Reciprocals": _TABLE,
        "ReplyTransmitter": _COUNTERS,
        "ReplyWords": _COUNTERS,
        "ResultCollector": _SMALL,
        "ResultQueue": "the queue's memory, because the store always takes a result; "
        "`make formal PROOF=result_queue` fills it",
        "ResultStore": "upper bits of sums over more paths and cells than the small chip has, and "
        "a reader that waits; `tests/unit/feasibility/test_result_store.py` does",
        "SkidBuffer": _FULL,
        "StreamRegister": _FULL,
        "UartReceiver": _FRAMING,
    },
}
