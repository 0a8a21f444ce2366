"""Both ends of the line on the chip's side: UART, COBS, frames."""
