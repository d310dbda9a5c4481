"""The catalogue: physics that a baseline model may leave out, one small entry each."""
