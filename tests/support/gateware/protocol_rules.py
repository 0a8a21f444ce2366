"""The rules by which a chip answers any undamaged frame, from docs/protocol.md, not the model."""

from pathgene.hdl.command.field_decoder import FOLLOWED, request_fields
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES
from pathgene.hdl.protocol.codes import Command, Status
from pathgene.hdl.protocol.messages import info_reply


_IN_ORDER = (Status.OK, Status.UNKNOWN_COMMAND, Status.BAD_LENGTH, Status.BAD_VALUE, Status.BUSY)


class ProtocolRules:
    """Session and sequence number of a chip since its reset, and the correct answer to each frame.

    Attributes
    ----------
    session, expected : int
        The open session, and the sequence number of its next command.
    """

    def __init__(self, config):
        self.config = config
        self.session = self.expected = 0
        self._fields = request_fields(config)

    def judge(self, body, plain, answer):
        """Assert that ``answer``, a body or None, is one that the chip may give to ``body``.

        Returns
        -------
        Status or None
            Status of the answer.
        """
        session, sequence, code = body[:BODY_HEADER_BYTES]
        if len(body) >= self.config.receive_buffer or (plain and code != Command.INFO):
            assert answer is None
            return None
        assert answer is not None
        told_session, told_sequence, number = answer[:BODY_HEADER_BYTES]
        status = Status(number)
        payload = answer[BODY_HEADER_BYTES:]
        assert status is Status.OK or not payload
        assert told_session == session
        assert told_sequence == (self.expected if status is Status.OUT_OF_ORDER else sequence)
        if plain:
            assert status is Status.OK
            assert info_reply(self.config).unpack(payload)["session"] == self.session
        elif code == Command.OPEN:
            self._judge_open(session, status, payload)
        elif session != self.session:
            assert status is Status.NO_SESSION
        else:
            self._judge_numbered(sequence, code, len(body) - BODY_HEADER_BYTES, status)
        return status

    def _judge_open(self, session, status, payload):
        opens = session == (self.session + 1) % 256
        assert (status is Status.OK) == (opens or session == self.session)
        assert status in (Status.OK, Status.NO_SESSION)
        assert not payload
        if opens:
            self.session, self.expected = session, 0

    def _judge_numbered(self, sequence, code, size, status):
        ahead = (sequence - self.expected) % 256
        if ahead not in (0, 255):
            assert status is (Status.OUT_OF_ORDER if ahead < 129 else Status.DUPLICATE)
            return
        assert status in _IN_ORDER
        assert (status is Status.UNKNOWN_COMMAND) == (code not in self._fields)
        if code in self._fields:
            fixed = self._fields[code].size
            if code not in FOLLOWED:
                assert (status is Status.BAD_LENGTH) == (size != fixed)
            elif size < fixed:
                assert status is Status.BAD_LENGTH
        if ahead == 0 and status is Status.OK:
            self.expected = (self.expected + 1) % 256
