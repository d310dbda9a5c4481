"""Recordings: one table of samples plus what is known about how it was taken."""

from pneuservo.recordings.channels import CHANNELS, Channel
from pneuservo.recordings.reader import read_recording
from pneuservo.recordings.recording import Recording
from pneuservo.recordings.writer import write_recording

__all__ = ["CHANNELS", "Channel", "Recording", "read_recording", "write_recording"]
