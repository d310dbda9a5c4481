"""The single-axis servo, block by block, each fed with what was measured round it."""
