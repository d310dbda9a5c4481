"""Sliding-mode control: surfaces, when they are reached, and the laws that switch."""
