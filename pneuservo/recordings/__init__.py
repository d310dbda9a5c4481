"""Recordings: one table of samples plus what is known about how it was taken."""

from pneuservo.recordings.channels import CHANNELS, Channel
from pneuservo.recordings.recording import Recording

__all__ = ["CHANNELS", "Channel", "Recording"]
