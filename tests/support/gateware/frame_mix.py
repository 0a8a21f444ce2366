"""Random frames with a correct checksum that keep or break the rules of the protocol."""

import collections
import random

import numpy as np

from pathgene.hdl.command.field_decoder import request_fields
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, CRC_BYTES
from pathgene.hdl.protocol.codes import Command, LinkMode
from pathgene.hdl.protocol.messages import map_request, results_request, write_request
from pathgene.hdl.protocol.paths import pack_paths
from pathgene.hdl.protocol.planner import EDGES, SCALE_FRACTION, no_fly_request
from pathgene.hdl.protocol.runs import RunOptions, run_request
from tests.support.gateware.chips import random_path
from tests.support.gateware.random_requests import RandomRequests
from tests.support.planner.cases import record


#: Kinds of frames, and how often each is drawn. *state*: a command at a wrong time, such as a BEST
#: without a run, or with a degenerate shape. *convention*: a plain frame with the CRC of the
#: version, or the reverse. *replay*: a repetition of a recent frame, whatever session is open now.
KINDS = {
    "legal": 40,
    "altered": 20,
    "length": 10,
    "sequence": 8,
    "session": 6,
    "unknown": 4,
    "convention": 4,
    "state": 4,
    "replay": 4,
}
#: Frames that may be replayed.
_REMEMBERED = 300
#: A RUN has fewer cycles, so that it ends soon even in simulated hardware.
_RUN_CYCLES = 1 << 17


class FrameMix:
    """Source of bodies, and of whether each is sent as a plain frame.

    The first frames after a reset ask for results before there are any.

    Parameters
    ----------
    rules : tests.support.gateware.protocol_rules.ProtocolRules
        Rules that know the open session and the expected number.
    """

    def __init__(self, config, rules, seed):
        self.config = config
        self._rules = rules
        self._rng = random.Random(seed)
        self._draws = np.random.default_rng(seed)
        self._requests = RandomRequests(config, self._rng, self._draws)
        self._fields = request_fields(config)
        self._sent = collections.deque(maxlen=_REMEMBERED)
        # Commands to send next, each with its distance from the expected number.
        self._next = [(code, payload, 0) for code, payload in self._too_early()]

    def draw(self):
        """Return the kind of the next frame, its body, and whether it is plain."""
        if self._next:
            code, payload, behind = self._next.pop(0)
            kind, (body, plain) = "state", (self._body(code, payload, behind), False)
        else:
            kind = self._rng.choices(list(KINDS), KINDS.values())[0]
            if kind == "state":
                self._next = self._at_a_wrong_time()
                return self.draw()
            body, plain = getattr(self, f"_{kind}")()
        body = self._bounded(body)
        self._sent.append((body, plain))
        return kind, body, plain

    def paths(self):
        """Return a WRITE of all slots."""
        return self._requests.paths(0, self.config.population)

    def _body(self, code, payload, behind=0):
        session = self._rules.session + (code == Command.OPEN)
        sequence = self._rules.expected - behind
        return bytes((session % 256, sequence % 256, code)) + payload

    def _legal(self):
        code = self._requests.command()
        return self._body(code, self._requests.payload(code)), code == Command.INFO

    def _altered(self):
        """Change the value of one field, often to a limit of its range, or flip a bit."""
        rng = self._rng
        code = rng.choice([code for code, layout in self._fields.items() if layout.fields])
        payload, layout = self._requests.payload(code), self._fields[code]
        if rng.random() < 0.3:
            changed = bytearray(payload)
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
            return self._body(code, bytes(changed)), False
        fields = layout.unpack(payload[: layout.size])
        name, width = rng.choice(layout.fields)
        values = {0, 1, fields[name] - 1, fields[name] + 1, rng.getrandbits(width)}
        values |= {(1 << width) - 1, (1 << width) - 2, 1 << width - 1, (1 << width - 1) - 1}
        for border in self._borders():
            values |= {border - 1, border, border + 1}
        fields[name] = rng.choice(sorted(value for value in values if 0 <= value < 1 << width))
        return self._body(code, layout.pack(**fields) + payload[layout.size :]), False

    def _borders(self):
        config = self.config
        return (
            config.population,
            config.map_size,
            config.blocked_altitude,
            config.max_waypoints,
            1 << SCALE_FRACTION,
        )

    def _length(self):
        """Cut the payload, or lengthen it, even beyond the receive buffer."""
        rng, (body, plain) = self._rng, self._legal()
        size, most = len(body), self.config.receive_buffer - CRC_BYTES
        sizes = (0, size - 1, size + 1, rng.randrange(size, most), most, most + rng.randrange(9))
        longer = body + rng.randbytes(most + 9)
        return longer[: max(rng.choice(sizes), BODY_HEADER_BYTES)], plain

    def _sequence(self):
        behind = self._rng.choice((1, 1, 1, 2, 127, 128, 129, 254, 255, self._rng.randrange(256)))
        code = self._requests.command()
        return self._body(code, self._requests.payload(code), behind), code == Command.INFO

    def _session(self):
        body, plain = self._legal()
        ahead = self._rng.choice((-2, -1, 1, 128, self._rng.randrange(256)))
        return bytes([(body[0] + ahead) % 256]) + body[1:], plain

    def _unknown(self):
        rng, (body, _) = self._rng, self._legal()
        codes = (0, rng.randrange(24), rng.randrange(256))
        unknown = [code for code in codes if code not in self._fields and code != Command.OPEN]
        return body[:2] + bytes([rng.choice(unknown or [255])]) + body[3:], False

    def _convention(self):
        body, plain = self._legal()
        return body, not plain

    def _replay(self):
        latest = self._rng.random() < 0.3
        return self._rng.choice([self._sent[-1]] if latest else self._sent)

    def _too_early(self):
        """Return commands that ask for results that a chip lacks after a reset."""
        if self.config.planner_core:
            cold = RunOptions(generations=1, cycles=1, seeds=self.config.population)
            warm = RunOptions(generations=1, warm=True, slopes=(), seeds=self.config.population)
            fields = run_request(self.config).unpack(cold.pack(self.config))
            codes = (Command.BEST, Command.STOP, Command.STATUS)
            return [
                *((code, b"") for code in codes),
                (Command.RUN, run_request(self.config).pack(**fields | {"seeds": 0})),
                (Command.RUN, cold.pack(self.config)),
                (Command.RUN, warm.pack(self.config)),
                (Command.PROBLEM, record(self.config, self._draws).pack(self.config)),
                (Command.BEST, b""),
                (Command.RUN, warm.pack(self.config)),
            ]
        results = results_request(self.config)
        return [
            (Command.RESULTS, results.pack(path=0, count=1)),
            (Command.STATUS, b""),
            (Command.GENERATE, bytes([LinkMode.POPULATION])),
        ]

    def _at_a_wrong_time(self):
        """Return commands at a wrong time, or with extremes that the host never sends."""
        rng, config, payload = self._rng, self.config, self._requests.payload
        corner = rng.randrange(config.map_size)
        nothing = map_request(config).pack(x=corner, y=corner, width=rng.randrange(2), height=0)
        if config.planner_core:
            return rng.choice(
                (
                    [(Command.PROBLEM, payload(Command.PROBLEM), 0), (Command.BEST, b"", 0)],
                    [(Command.RUN, payload(Command.RUN), 0), (Command.RUN, b"", 1)],
                    [(Command.RUN, payload(Command.RUN), behind) for behind in (0, 1, 0)],
                    [(Command.STOP, b"", 0), (Command.BEST, b"", 0), (Command.STOP, b"", 1)],
                    [(Command.BLOCK, self._extreme_shape(), 0)],
                    [(Command.MAP, nothing, 0)],
                )
            )
        order = bytes(rng.choices(range(config.population), k=config.population))
        ranked = payload(Command.GENERATE)
        short = [random_path(config, rng, rng.choice((1, 1 + config.max_waypoints)))]
        slot = rng.randrange(config.population)
        write = write_request(config).pack(slot=slot) + pack_paths(config, short)
        whole = write_request(config).pack(slot=slot) + self.paths()[1:]
        modes = [bytes([mode]) + ranked[1:] for mode in LinkMode]
        return rng.choice(
            (
                [(Command.GENERATE, bytes([rng.randrange(4)]) + order, 0)],
                [(Command.GENERATE, ranked, 0), *((Command.GENERATE, mode, 1) for mode in modes)],
                [(Command.CHECK, payload(Command.CHECK), 0), (Command.RESULTS, b"\1\1", 0)],
                [(Command.WRITE, write, 0)],
                [(Command.WRITE, whole, 0)],
                [(Command.MAP, nothing, 0)],
            )
        )

    def _extreme_shape(self):
        """Return a BLOCK of one, all or no corners, with extremes of every edge."""
        rng, layout = self._rng, no_fly_request(self.config)
        widths = dict(layout.fields)
        fields = {
            name: rng.choice((0, 1, (1 << width) - 1, 1 << width - 1, (1 << width - 1) - 1))
            for name, width in layout.fields
        }
        for i in range(rng.randrange(EDGES), EDGES):
            fields |= dict.fromkeys((f"at_{i}", f"east_{i}", f"north_{i}"), 0)
        top = (1 << widths["first_x"]) - 1
        low, high = rng.choice(((0, top), (top, 0), (top // 2, top // 2), (top, top), (0, 0)))
        return layout.pack(**fields | {"first_x": low, "first_y": low, "last_x": high})

    def _bounded(self, body):
        """Limit a RUN so that it ends soon."""
        layout = self._fields.get(Command.RUN)
        if body[2] != Command.RUN or layout is None or len(body) != BODY_HEADER_BYTES + layout.size:
            return body
        fields = layout.unpack(body[BODY_HEADER_BYTES:])
        few = 4 * self.config.population
        fields["cycles"] %= _RUN_CYCLES
        fields["seeds"] = min(fields["seeds"], few)
        return body[:BODY_HEADER_BYTES] + layout.pack(**fields)
