"""Payloads of the streams between the units of the planner."""

from amaranth.hdl import signed
from amaranth.lib import data

from hdl.config import Config
from hdl.protocol.planner import BASE_BITS, problem_request


__all__ = ["problem_layout"]


def problem_layout(config: Config) -> data.StructLayout:
    """Return the layout of a problem's record: the request's, but ``base`` with its sign."""
    fields = dict(problem_request(config).fields)
    assert fields["base"] == BASE_BITS
    return data.StructLayout({**fields, "base": signed(BASE_BITS)})
