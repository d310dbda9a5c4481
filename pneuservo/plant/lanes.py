"""Eight numbers side by side, on which kernels work as they do on one.

The equations of the plant are written once. Called with floats they advance one run; called with
`Lanes` they advance eight at a time in the wide registers of the processor. Comparisons of lanes
give a `Mask`, so that kernels which serve both choose with `select` instead of branching. Inside
compiled code only.
"""

import math
import operator
from typing import Any

import numba
from llvmlite import ir
from numba.core import cgutils
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typeconv import Conversion
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import models, register_model

# Their stubs do not know what compiled code is allowed.
types: Any = numba.types
intrinsic: Any = numba.extending.intrinsic

WIDTH = 8
VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)
_BITS = ir.VectorType(ir.IntType(1), WIDTH)
INDEX = ir.IntType(64)


class Lanes(types.Type):
    """Eight floats; a single float can stand for eight equal ones."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")

    def can_convert_from(self, typingctx, other):
        """Return how good a conversion is, for the compiler."""
        return Conversion.safe if other == types.float64 else None

    def unify(self, typingctx, other):
        """Return what a variable is that is lanes here and a float there, for the compiler."""
        return self if other == types.float64 else None


class Mask(types.Type):
    """Eight truth values."""

    def __init__(self) -> None:
        super().__init__(name="Mask")


LANES, MASK = Lanes(), Mask()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, VECTOR)


@register_model(Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _BITS)


def spread(builder, value):
    """Return a value in all lanes, for lowering."""
    if value.type == VECTOR:
        return value
    first = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), value, position(0))
    order = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(first, ir.Constant(VECTOR, ir.Undefined), order)


@lower_cast(types.float64, Lanes)
def _cast(context, builder, from_type, to_type, value):
    return spread(builder, value)


def position(lane):
    """Return where a lane is, as the compiler takes it."""
    return ir.Constant(ir.IntType(32), lane)


def _compare(builder, sign, left, right):
    ordered = builder.fcmp_unordered if sign == "!=" else builder.fcmp_ordered
    return ordered(sign, left, right)


def _register(function, result, lower):
    """Make an operator of two numbers work on lanes, and on lanes beside one float."""
    pairs = ((LANES, LANES), (LANES, types.float64), (types.float64, LANES))

    class Template(ConcreteTemplate):
        cases = tuple(signature(result, *pair) for pair in pairs)

    infer_global(function)(Template)

    def implementation(context, builder, sig, args):
        return lower(builder, *(spread(builder, value) for value in args))

    for pair in pairs:
        lower_builtin(function, *pair)(implementation)


def _register_unary(function, kind, lower):
    class Template(ConcreteTemplate):
        cases = (signature(kind, kind),)

    infer_global(function)(Template)
    lower_builtin(function, kind)(lambda context, builder, sig, args: lower(builder, args[0]))


def _library(name):
    """Return a lowering that calls an elementary function of the compiler."""

    def lower(builder, value):
        kind = ir.FunctionType(VECTOR, [VECTOR])
        function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64")
        return builder.call(function, [value])

    return lower


def _chooser(sign):
    return lambda builder, a, b: builder.select(_compare(builder, sign, a, b), a, b)


for _function, _name in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
    (operator.iadd, "fadd"),
    (operator.isub, "fsub"),
    (operator.imul, "fmul"),
):
    _register(_function, LANES, lambda b, x, y, name=_name: getattr(b, name)(x, y))
for _function, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
    (operator.ne, "!="),
):
    _register(_function, MASK, lambda b, x, y, sign=_sign: _compare(b, sign, x, y))
_register(min, LANES, _chooser("<"))
_register(max, LANES, _chooser(">"))
_register_unary(operator.neg, LANES, lambda builder, value: builder.fneg(value))
_register_unary(abs, LANES, _library("fabs"))
_register_unary(math.sqrt, LANES, _library("sqrt"))


@intrinsic
def select(typing, condition, this, other):
    """Return one value where a condition holds and another where it does not, without a branch."""
    wide = LANES in (this, other) or condition == MASK
    result = LANES if wide else types.float64

    def lower(context, builder, sig, args):
        chosen = [
            value if kind == LANES else context.cast(builder, value, kind, types.float64)
            for value, kind in zip(args[1:], sig.args[1:], strict=True)
        ]
        if wide:
            chosen = [spread(builder, value) for value in chosen]
        return builder.select(args[0], *chosen)

    return signature(result, condition, this, other), lower


@intrinsic
def both(typing, left, right):
    """Return where two conditions hold."""
    return signature(left, left, right), lambda _c, builder, _s, args: builder.and_(*args)


@intrinsic
def whole(typing, value):
    """Return a number without its fraction, as a number of the same kind."""
    name = f"llvm.trunc.v{WIDTH}f64" if value == LANES else "llvm.trunc.f64"

    def lower(context, builder, sig, args):
        kind = ir.FunctionType(args[0].type, [args[0].type])
        function = cgutils.get_or_insert_function(builder.module, kind, name)
        return builder.call(function, args)

    return signature(value, value), lower


@intrinsic
def first_lane(typing, value):
    """Return the number of the first lane; a single number is itself."""

    def lower(context, builder, sig, args):
        if value != LANES:
            return args[0]
        return builder.extract_element(args[0], position(0))

    return signature(types.float64, value), lower


@intrinsic
def lanes_that(typing, mask):
    """Return an integer with the bit of every lane set in which a condition holds."""

    def lower(context, builder, sig, args):
        packed = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.zext(packed, INDEX)

    return signature(types.int64, mask), lower
