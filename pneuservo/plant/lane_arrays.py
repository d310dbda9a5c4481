"""Lanes from arrays and into them."""

from llvmlite import ir
from numba.core.errors import TypingError
from numba.core.typing.templates import signature

from pneuservo.plant.lanes import INDEX, LANES, VECTOR, WIDTH, intrinsic, position, spread, types

# Bytes: rows of lanes lie anywhere in an array of doubles.
_ALIGNMENT = 8


def _require_rows(array):
    """Refuse an array that does not lie in C order: its rows would not be where they are read."""
    if getattr(array, "layout", None) != "C" or array.dtype != types.float64:
        raise TypingError(f"{array} is no array of doubles in C order; make it one before the call")


def _row_pointer(context, builder, array_type, array, row):
    """Return where a row of a C-ordered array of doubles with `WIDTH` columns starts."""
    data = context.make_array(array_type)(context, builder, array).data
    return builder.gep(data, [builder.mul(row, ir.Constant(row.type, WIDTH))])


def _load(builder, pointer, kind):
    return builder.load(builder.bitcast(pointer, kind.as_pointer()), align=_ALIGNMENT)


@intrinsic
def load_row(typing, array, row):
    """Return a row of an (n, 8) array as lanes; the row is not checked."""
    _require_rows(array)

    def lower(context, builder, sig, args):
        pointer = _row_pointer(context, builder, sig.args[0], args[0], args[1])
        return _load(builder, pointer, VECTOR)

    return signature(LANES, array, types.intp), lower


@intrinsic
def store_row(typing, array, row, value):
    """Write lanes into a row of an (n, 8) array; the row is not checked."""
    _require_rows(array)

    def lower(context, builder, sig, args):
        pointer = _row_pointer(context, builder, sig.args[0], args[0], args[1])
        target = builder.bitcast(pointer, VECTOR.as_pointer())
        builder.store(spread(builder, args[2]), target, align=_ALIGNMENT)
        return context.get_dummy_value()

    return signature(types.none, array, types.intp, value), lower


@intrinsic
def store_rows(typing, array, values):
    """Write a tuple of lanes into the first rows of an (n, 8) array, which is not checked."""
    _require_rows(array)

    def lower(context, builder, sig, args):
        for row in range(len(values)):
            pointer = _row_pointer(context, builder, sig.args[0], args[0], ir.Constant(INDEX, row))
            target = builder.bitcast(pointer, VECTOR.as_pointer())
            value = spread(builder, builder.extract_value(args[1], row))
            builder.store(value, target, align=_ALIGNMENT)
        return context.get_dummy_value()

    return signature(types.none, array, values), lower


def _leaf_count(kind):
    if isinstance(kind, types.BaseTuple):
        return sum(_leaf_count(each) for each in kind.types)
    return 1 if isinstance(kind, types.Float) else 0


def _with_leaves(kind, leaf):
    """Return a type of tuples with another type in place of every float."""
    if isinstance(kind, types.BaseTuple):
        members = [_with_leaves(each, leaf) for each in kind.types]
        return types.BaseTuple.from_types(members, getattr(kind, "instance_class", None))
    return leaf if isinstance(kind, types.Float) else kind


def _rebuild(context, builder, kind, example, result, leaves):
    """Return a tuple like an example, with floats taken from an iterator; integers stay."""
    if not isinstance(kind, types.BaseTuple):
        return next(leaves) if isinstance(kind, types.Float) else example
    members = [
        _rebuild(context, builder, each, builder.extract_value(example, i), result.types[i], leaves)
        for i, each in enumerate(kind.types)
    ]
    return context.make_tuple(builder, result, members)


@intrinsic
def load_lanes(typing, array, example):
    """Return a tuple like an example, its floats replaced by the rows of an (n, 8) array.

    Integers are the example's; the number of rows is not checked.
    """
    _require_rows(array)
    result = _with_leaves(example, LANES)

    def lower(context, builder, sig, args):
        rows = (
            _load(
                builder,
                _row_pointer(context, builder, sig.args[0], args[0], ir.Constant(INDEX, row)),
                VECTOR,
            )
            for row in range(_leaf_count(example))
        )
        return _rebuild(context, builder, example, args[1], result, rows)

    return signature(result, array, example), lower


def _load_spaced(context, builder, array_type, array, start, spacing, example, value, result):
    """Return a tuple like an example, with floats that lie evenly spaced in an array."""
    data = context.make_array(array_type)(context, builder, array).data
    floats = (
        builder.load(builder.gep(data, [builder.add(start, ir.Constant(INDEX, spacing * place))]))
        for place in range(_leaf_count(example))
    )
    return _rebuild(context, builder, example, value, result, floats)


@intrinsic
def load_lane(typing, array, lane, example):
    """Return a tuple like an example, its floats from one column of an (n, 8) array."""
    _require_rows(array)
    result = _with_leaves(example, types.float64)

    def lower(context, builder, sig, args):
        array_type, start = sig.args[0], args[1]
        return _load_spaced(
            context, builder, array_type, args[0], start, WIDTH, example, args[2], result
        )

    return signature(result, array, types.intp, example), lower


@intrinsic
def load_tuple(typing, array, example):
    """Return a tuple like an example, its floats those at the start of an array."""
    _require_rows(array)
    result = _with_leaves(example, types.float64)

    def lower(context, builder, sig, args):
        start = ir.Constant(INDEX, 0)
        return _load_spaced(
            context, builder, sig.args[0], args[0], start, 1, example, args[1], result
        )

    return signature(result, array, example), lower


@intrinsic
def neighbours(typing, table, index):
    """Return the number at an index of a flat table, and the one after it.

    Parameters
    ----------
    table : array
        In C order; seen as one row.
    index : float or Lanes
        A whole number; it is not checked.
    """
    _require_rows(table)
    result = types.UniTuple(index, 2)

    def pair(builder, data, position):
        return _load(builder, builder.gep(data, [position]), ir.VectorType(ir.DoubleType(), 2))

    def lower(context, builder, sig, args):
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        if index != LANES:
            both_numbers = pair(builder, data, builder.fptosi(args[1], INDEX))
            members = [builder.extract_element(both_numbers, position(i)) for i in range(2)]
            return context.make_tuple(builder, result, members)
        places = builder.fptosi(args[1], ir.VectorType(INDEX, WIDTH))
        # The two numbers of a lane lie side by side: one load for both, then joined in a tree.
        parts = [
            pair(builder, data, builder.extract_element(places, position(lane)))
            for lane in range(WIDTH)
        ]
        while len(parts) > 1:
            parts = [_join(builder, a, b) for a, b in zip(parts[::2], parts[1::2], strict=True)]
        members = [_every_second(builder, parts[0], start) for start in range(2)]
        return context.make_tuple(builder, result, members)

    return signature(result, table, index), lower


def _join(builder, left, right):
    count = left.type.count
    order = ir.Constant(ir.VectorType(ir.IntType(32), 2 * count), list(range(2 * count)))
    return builder.shuffle_vector(left, right, order)


def _every_second(builder, values, start):
    order = list(range(start, 2 * WIDTH, 2))
    kind = ir.VectorType(ir.IntType(32), WIDTH)
    return builder.shuffle_vector(
        values, ir.Constant(values.type, ir.Undefined), ir.Constant(kind, order)
    )
