"""The identity of a board: its protocol version, build and configuration."""

from __future__ import annotations

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import VERSION
from pathgene.hdl.protocol.messages import config_from_info, info_reply
from pathgene.host.device.link import Link
from pathgene.host.errors import InputError


__all__ = ["built_config", "request_info"]


def request_info(link: Link) -> dict[str, int]:
    """Return the fields of the board's reply to ``INFO``.

    Raises
    ------
    LinkTimeoutError
        If nothing answers.
    InputError
        If the board has another protocol version.
    """
    reply = link.info()
    # The reply of every protocol version begins with version and build.
    version = reply[0] if reply else 0
    if version != VERSION:
        raise InputError(
            f"The board speaks protocol version {version}, this host version {VERSION}: "
            "load a bitstream of this release, or use the release the board was built with."
        )
    return info_reply(Config()).unpack(reply)


def built_config(info: dict[str, int]) -> Config:
    """Return the configuration that the board was built from.

    Parameters
    ----------
    info : dict
        From :func:`request_info`.

    Raises
    ------
    InputError
        If the build is unknown.
    """
    try:
        config = config_from_info(info)
    except ValueError as error:
        raise InputError(
            f"This release does not know the build of the board ({error}): load a bitstream of "
            "this release."
        ) from None
    if config.build_id != info["build_id"]:
        raise InputError(
            f"The board was built as {info['build_id']:08x}, but the sizes that it reports make "
            f"{config.build_id:08x} here: load a bitstream of this release."
        )
    return config
