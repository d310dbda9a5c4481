"""The pneumatic servo: plant, control, recordings, and the diagnosis of what a model leaves out."""
