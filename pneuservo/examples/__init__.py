"""Recordings that the program makes itself, by code that shares no equation with the rest."""
