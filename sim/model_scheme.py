"""Boards of the scheme ``model:``: the software model, in this process."""

from __future__ import annotations

from pathgene.hdl.config import Config
from pathgene.host.device.schemes import CONFIG_FIELDS, BoardScheme, OpenPort
from pathgene.host.errors import InputError, JobError
from pathgene.sim.chip_url import PORT, chip_of
from pathgene.sim.model.chip import Chip, ModelPort
from pathgene.sim.served_model import ServedModel


__all__ = ["SCHEME", "ModelScheme"]


class ModelScheme(BoardScheme):
    """``model:`` with ``port`` and the fields of the configuration as its options."""

    simulated = True

    def open(self, url: str) -> OpenPort:
        """Make the model."""
        # The model answers while it is written to: silence means a damaged frame.
        return OpenPort(ModelPort(Chip(_config(url))), timeout_s=0.01, attempts=12)

    def known_config(self, url: str) -> Config:
        """Return the configuration that the URL specifies."""
        return chip_of(url)[1]

    def serve(self, url: str, *, listen: str, pty: bool) -> ServedModel:
        """Make the model, which keeps its state when a client leaves."""
        chip = Chip(_config(url))
        try:
            return ServedModel(chip, listen=listen, pty=pty)
        except OSError as error:
            reason = error.strerror or "unknown reason"
            raise JobError(f"The model cannot be served at {listen!r}: {reason}.") from None


def _config(url: str) -> Config:
    """Return the configuration of a URL that has no other options."""
    rest, config = chip_of(url)
    if rest != "model:":
        raise InputError(
            f"The model takes only {PORT} and fields of the configuration, not {rest!r}; they are "
            f"{', '.join(CONFIG_FIELDS)}."
        )
    return config


#: The entry point ``model`` refers to this object.
SCHEME = ModelScheme()
