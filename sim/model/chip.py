"""Model of the whole chip at its UART, byte for byte, and its serial port: the board ``model:``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol.breeding import Recipe
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, encode_frame
from pathgene.hdl.protocol.codes import ChipState, Command, Counter, LinkMode, Status, StickyError
from pathgene.hdl.protocol.messages import (
    counters_reply,
    generate_request,
    info_reply,
    info_values,
    read_request,
    recipe_reply,
    start_request,
    status_reply,
    survivors_reply,
    write_request,
)
from pathgene.hdl.protocol.paths import pack_paths, unpack_paths
from pathgene.sim.model.core import Generation, PaperCore
from pathgene.sim.model.mutation import Limits
from pathgene.sim.model.requests import FrameReceiverModel, RefusedError, expect


__all__ = ["Chip", "ModelPort"]


if TYPE_CHECKING:
    from pathgene.sim.model.check_commands import CheckingModel
    from pathgene.sim.model.run_commands import RunningModel


class Chip:
    """Answers requests as the chip does.

    The cycles of core and checker equal the chip's exactly. The cycles of receiver and transmitter
    count the bytes on the line; the chip takes a few more per command.

    Attributes
    ----------
    core : PaperCore
        Population and random source, which tests compare with the gateware. On a chip without a
        paper core, no command reaches it.
    """

    def __init__(self, config: Config) -> None:
        self.config = config
        self.checking = _checking(config)
        self.running = self._running()
        self.core = PaperCore(config, self.checking.terrain if self.checking else None)
        self._receiver = FrameReceiverModel(config)
        self._session = 0
        self._expected = 0
        self._errors = StickyError(0)
        self._latest: Generation | None = None
        self._counters = dict.fromkeys(Counter, 0)
        self._states = [ChipState.LISTEN]
        self._commands: dict[int, Callable[[bytes, bool], bytes]] = {
            Command.STATUS: self._status,
            Command.COUNTERS: self._count,
            Command.CLEAR: self._clear,
        }
        if config.paper_core:
            self._commands |= {
                Command.START: self._start,
                Command.WRITE: self._write,
                Command.GENERATE: self._generate,
                Command.READ: self._read,
            }
        if self.checking:
            self._commands[Command.MAP] = self.checking.write
        if self.running and self.checking:
            self._commands |= {
                Command.CODED_MAP: self.checking.write_coded,
                Command.PROBLEM: self.running.set_problem,
                Command.RUN: self.running.run,
                Command.STOP: self.running.stop,
                Command.BEST: self.running.best,
                Command.BLOCK: self.running.block,
                Command.GUIDE: self.running.guide,
            }
        elif self.checking:
            self._commands |= {Command.CHECK: self._check, Command.RESULTS: self.checking.results}
        if config.paper_core and self.checking:
            self._commands[Command.CHECK_PATHS] = self._check_paths

    def feed(self, data: bytes) -> bytes:
        """Receive ``data`` from the line and return the answers of the chip."""
        self._counters[Counter.BYTES_RECEIVED] += len(data)
        self._pass_time(Counter.RECEIVE, len(data))
        answers = bytearray()
        for body, plain in self._receiver.feed(data):
            answer = self._answer(body, plain)
            self._enter(ChipState.TRANSMIT)
            if answer is not None:
                sent = encode_frame(answer, plain=plain)
                self._counters[Counter.BYTES_SENT] += len(sent)
                self._pass_time(Counter.TRANSMIT, len(sent))
                answers += sent
            self._enter(ChipState.LISTEN)
        return bytes(answers)

    def close(self) -> None:
        """End a run in progress whose result is no longer needed."""
        if self.running:
            self.running.end()

    def _pass_time(self, counter: Counter, line_bytes: int) -> None:
        cycles = line_bytes * self.config.byte_cycles
        self._counters[counter] += cycles
        self._counters[Counter.CYCLES] += cycles

    def _enter(self, state: ChipState) -> None:
        self._states = [state, *self._states[:7]]

    def _answer(self, body: bytes, plain: bool) -> bytes | None:
        self._enter(ChipState.RECEIVE)
        session, sequence, code = body[:BODY_HEADER_BYTES]
        payload = body[BODY_HEADER_BYTES:]
        if plain:
            if code != Command.INFO:
                return None
            reply = info_reply(self.config).pack(session=self._session, **info_values(self.config))
            return bytes((session, sequence, Status.OK)) + reply
        if code == Command.OPEN:
            return bytes((session, sequence, self._open(session)))
        if session != self._session:
            return bytes((session, sequence, Status.NO_SESSION))

        ahead = (sequence - self._expected) % 256
        if ahead not in (0, 255):
            if ahead < 129:
                return bytes((session, self._expected, Status.OUT_OF_ORDER))
            return bytes((session, sequence, Status.DUPLICATE))
        try:
            execute = self._commands.get(code)
            if execute is None:
                raise RefusedError(Status.UNKNOWN_COMMAND)
            if self.running and code not in (Command.STATUS, Command.STOP, Command.BEST):
                self.running.settle()
            reply = execute(payload, ahead == 255)
        except RefusedError as refused:
            self._errors |= StickyError.REFUSED
            return bytes((session, sequence, refused.status))
        if ahead == 0:
            self._expected = (self._expected + 1) % 256
        return bytes((session, sequence, Status.OK)) + reply

    def _open(self, session: int) -> Status:
        if session == (self._session + 1) % 256:
            self._session = session
            self._expected = 0
        return Status.OK if session == self._session else Status.NO_SESSION

    def _status(self, payload: bytes, repeated: bool) -> bytes:
        expect(not payload, Status.BAD_LENGTH)
        latest = self._latest
        done = {
            "generation": self.core.generation & 0xFFFFFFFF,
            "crossover": latest.crossover_cycles if latest else 0,
            "mutation": latest.mutation_cycles if latest else 0,
            "update": latest.update_cycles if latest else 0,
        }
        # The registers are read when the answer is built.
        states = (ChipState.TRANSMIT, *self._states[:7])
        return status_reply(self.config).pack(
            state=states[0],
            history=sum(state << 4 * age for age, state in enumerate(states)),
            errors=self._errors | self._receiver.errors,
            **(self.running.status() if self.running else done),
        )

    def _start(self, payload: bytes, repeated: bool) -> bytes:
        layout = start_request(self.config)
        expect(len(payload) == layout.size, Status.BAD_LENGTH)
        values = layout.unpack(payload)
        highest = self.config.map_size - 1
        expect(values["x"] <= highest and values["y"] <= highest, Status.BAD_VALUE)
        expect(values["altitude"] < self.config.blocked_altitude, Status.BAD_VALUE)
        expect(not values["avoid_ground"] or self.checking is not None, Status.BAD_VALUE)
        if not repeated:
            limits = Limits(values["x"], values["y"], values["altitude"])
            self.core.start(values["seed"], limits, bool(values["avoid_ground"]))
            self._counters[Counter.LONGEST] = 0
        return b""

    def _write(self, payload: bytes, repeated: bool) -> bytes:
        header = write_request(self.config).size
        expect(len(payload) > header, Status.BAD_LENGTH)
        expect((len(payload) - header) % self.config.waypoint_bytes == 0, Status.BAD_LENGTH)
        slot = payload[0]
        try:
            paths = unpack_paths(self.config, payload[header:])
        except ValueError:
            raise RefusedError(Status.BAD_VALUE) from None
        expect(slot + len(paths) <= self.config.population, Status.BAD_VALUE)
        if not repeated:
            self.core.paths[slot : slot + len(paths)] = paths
        return b""

    def _read(self, payload: bytes, repeated: bool) -> bytes:
        layout = read_request(self.config)
        expect(len(payload) == layout.size, Status.BAD_LENGTH)
        slot, count = payload
        expect(count >= 1 and slot + count <= self.config.population, Status.BAD_VALUE)
        return pack_paths(self.config, self.core.paths[slot : slot + count])

    def _generate(self, payload: bytes, repeated: bool) -> bytes:
        expect(len(payload) > 0, Status.BAD_LENGTH)
        expect(payload[0] in tuple(LinkMode), Status.BAD_VALUE)
        mode = LinkMode(payload[0])
        expect(len(payload) == generate_request(self.config, mode).size, Status.BAD_LENGTH)
        if not repeated:
            slots = list(range(self.config.population))
            order = slots if mode is LinkMode.POPULATION else list(payload[1:])
            expect(sorted(order) == slots, Status.BAD_VALUE)
            self._run(order)
        if mode is LinkMode.POPULATION:
            return pack_paths(self.config, self.core.paths)
        if mode is LinkMode.RECIPE:
            return self._recipe()
        latest = self._latest
        survivors = latest.survivors if latest else (0,) * self.config.survivors
        children = self.core.paths[self.config.elites + self.config.survivors :]
        named = {f"survivor_{i}": slot for i, slot in enumerate(survivors)}
        return survivors_reply(self.config).pack(**named) + pack_paths(self.config, children)

    def _running(self) -> RunningModel | None:
        if not self.config.planner_core:
            return None
        # This import compiles kernels, too.
        from pathgene.sim.model.run_commands import RunningModel

        assert self.checking is not None
        return RunningModel(self.config, self.checking.terrain)

    def _run(self, order: list[int]) -> None:
        latest = self._latest = self.core.run(order)
        spent = (
            (Counter.CROSSOVER, ChipState.CROSSOVER, latest.crossover_cycles),
            (Counter.MUTATION, ChipState.MUTATE, latest.mutation_cycles),
            (Counter.UPDATE, ChipState.UPDATE, latest.update_cycles),
        )
        for counter, state, cycles in spent:
            self._enter(state)
            self._counters[counter] += cycles
            self._counters[Counter.CYCLES] += cycles
        longest = sum(cycles for _, _, cycles in spent)
        self._counters[Counter.LONGEST] = max(self._counters[Counter.LONGEST], longest)
        self._counters[Counter.GENERATIONS] += 1
        self._counters[Counter.REFUSED_MUTATIONS] += latest.refused
        self._counters[Counter.REDRAWN] += latest.redrawn
        self._counters[Counter.LEFT_OUT] += latest.left_out

    def _recipe(self) -> bytes:
        if self._latest is None:
            blank = bytes(recipe_reply(self.config).size)
            recipe, _ = Recipe.unpack(self.config, blank)
        else:
            recipe = self._latest.recipe
        return recipe.pack(self.config, self.core.checksum())

    def _check(self, payload: bytes, repeated: bool) -> bytes:
        assert self.checking is not None
        reply = self.checking.check(payload, repeated)
        self._note_check(repeated)
        return reply

    def _check_paths(self, payload: bytes, repeated: bool) -> bytes:
        assert self.checking is not None
        reply = self.checking.check_paths(self.core.paths, payload, repeated)
        self._note_check(repeated)
        return reply

    def _note_check(self, repeated: bool) -> None:
        assert self.checking is not None
        if not repeated:
            self._enter(ChipState.CHECK)
            spent = self.checking.counters[Counter.FEASIBILITY]
            self._counters[Counter.CYCLES] += spent - self._counters[Counter.FEASIBILITY]
            self._counters |= self.checking.counters

    def _count(self, payload: bytes, repeated: bool) -> bytes:
        expect(not payload, Status.BAD_LENGTH)
        counters = dict(self._counters)
        if self.running:
            counters[Counter.CYCLES] += self.running.cycles
            counters[Counter.GENERATIONS] += self.running.generations
        wrapped = {name.value: count & ((1 << 48) - 1) for name, count in counters.items()}
        return counters_reply(self.config).pack(**wrapped)

    def _clear(self, payload: bytes, repeated: bool) -> bytes:
        expect(not payload, Status.BAD_LENGTH)
        if not repeated:
            self._errors = self._receiver.errors = StickyError(0)
        return b""


def _checking(config: Config) -> CheckingModel | None:
    if config.checker is CheckerBuild.NONE:
        return None
    # This import compiles kernels, for which a chip without a checker need not wait.
    from pathgene.sim.model.check_commands import CheckingModel

    return CheckingModel(config)


class ModelPort:
    """The methods of :class:`serial.Serial` that a link uses, over a :class:`Chip`.

    The model answers during a write, so a read never waits: bytes that are missing only arrive
    after another write.
    """

    def __init__(self, chip: Chip) -> None:
        self.chip = chip
        self.timeout: float | None = None
        self.write_timeout: float | None = None  # A write never waits.
        self._received = bytearray()

    @property
    def in_waiting(self) -> int:
        """Bytes that :meth:`read` would return."""
        return len(self._received)

    def read(self, size: int = 1) -> bytes:
        """Return at most ``size`` bytes of those that the chip has sent."""
        part = bytes(self._received[:size])
        del self._received[:size]
        return part

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Pass ``data`` to the chip and return its length."""
        self._received += self.chip.feed(bytes(data))
        return len(data)

    def flush(self) -> None:
        """Do nothing: all written bytes have arrived."""

    def close(self) -> None:
        """End the work of the model."""
        self.chip.close()
