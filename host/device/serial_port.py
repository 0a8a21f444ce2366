"""A port of pyserial: a serial device or any URL that pyserial knows."""

from __future__ import annotations


__all__ = ["SerialPort"]


class SerialPort:
    """A port of pyserial as a :class:`pathgene.host.device.transport.Transport`.

    Parameters
    ----------
    url : str
        Device or URL of pyserial. It is opened in shared mode: another process may have it open.
    baud : int
        Rate of the line, bits per second.

    Raises
    ------
    OSError, ValueError
        From the constructor, if there is no such port. Every other method raises
        :class:`OSError` when the port fails.
    """

    def __init__(self, url: str, baud: int) -> None:
        import serial

        self._port = serial.serial_for_url(url, baudrate=baud, timeout=0, exclusive=None)
        self._timed_out = serial.SerialTimeoutException

    @property
    def timeout(self) -> float | None:
        """Longest wait of :meth:`read`, seconds."""
        timeout: float | None = self._port.timeout
        return timeout

    @timeout.setter
    def timeout(self, timeout_s: float | None) -> None:
        self._port.timeout = timeout_s

    @property
    def write_timeout(self) -> float | None:
        """Longest wait of :meth:`write`, seconds; None if pyserial's limit is fixed."""
        timeout: float | None = self._port.write_timeout
        return timeout

    @write_timeout.setter
    def write_timeout(self, timeout_s: float | None) -> None:
        try:
            self._port.write_timeout = timeout_s
        except NotImplementedError:
            # rfc2217:// has no such setting and ends each write after 5 s. It would reject all
            # settings now.
            self._port.write_timeout = None

    @property
    def in_waiting(self) -> int:
        """Bytes that :meth:`read` would return at once."""
        count: int = self._port.in_waiting
        return count

    def read(self, size: int = 1) -> bytes:
        """Return ``size`` bytes, or fewer if the timeout comes first."""
        data: bytes = self._port.read(size)
        return data

    def write(self, data: bytes) -> int | None:
        """Send all of ``data``.

        Raises
        ------
        TimeoutError
            If ``write_timeout`` passes first. Some of ``data`` may have been sent.
        """
        try:
            count: int | None = self._port.write(data)
        except self._timed_out as error:
            raise TimeoutError(str(error)) from None
        return count

    def close(self) -> None:
        """Close the port."""
        self._port.close()
