"""Arrays written into others, for kernels.

Assigning an array to a slice of another brings along the text of the error that differing shapes
would be: two seconds of compilation, and more in every kernel that takes it in.
"""

from pneuservo.plant.compilation import compiled


@compiled
def put(source, target):
    """Write a row into another that is as long or longer.

    Parameters
    ----------
    source, target : (n,) array
        What is written, and where.
    """
    for i in range(source.shape[0]):
        target[i] = source[i]


@compiled
def put_table(source, target):
    """Write a table into another of the same shape.

    Parameters
    ----------
    source, target : (n, m) array
        What is written, and where.
    """
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]
