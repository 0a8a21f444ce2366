"""Command units: receiver, decoder, a parser for each kind of payload, and transmitter."""
