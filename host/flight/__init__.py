"""Flights of planned tracks in a flight-dynamics model, and what they prove."""
