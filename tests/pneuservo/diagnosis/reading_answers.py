"""What tests of planted truths ask of an answer."""


def named(answer):
    """Ids of the effects that were named."""
    return {entry["effect"] for entry in answer["missing"]}


def entry_of(answer, effect):
    """The entry that names an effect."""
    (entry,) = (entry for entry in answer["missing"] if entry["effect"] == effect)
    return entry


def separable(answer):
    """Sets of effects that the answer says it cannot tell apart."""
    return [set(entry["effects"]) for entry in answer["cannot_separate"]]


def assert_recovered(parameter, truth):
    """The truth lies within the stated interval, made twice as wide.

    A 95 % interval misses one truth in twenty and these tests hold about fifty of them; of twice
    the width it is one in ten thousand. The intervals are linearised about the best fit and know
    nothing of what the catalogue's law and the truth's differ in.
    """
    reach = parameter["high"] - parameter["low"]
    low, high = parameter["low"] - reach / 2.0, parameter["high"] + reach / 2.0
    assert low <= truth <= high, f"{truth} is not within {low} to {high}"
