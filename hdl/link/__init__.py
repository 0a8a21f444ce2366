"""The chip's end of the line, in both directions: UART, COBS, frames."""
