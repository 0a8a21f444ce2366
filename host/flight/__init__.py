"""Flights of planned tracks in a flight-dynamics model, as proof that the tracks can be flown."""
