"""How numba compiles the functions of :mod:`halftone._lanes`: one LLVM vector value each.

Nothing here names a processor. LLVM splits a vector into the registers there are: <32 x float> is
two of AVX-512's, eight of SSE's or NEON's.
"""

# mypy: disable-error-code="attr-defined,misc,untyped-decorator"
from __future__ import annotations

import operator
from typing import Any

from halftone import _lanes

__all__ = ["register"]

_registered = False


def register() -> None:
    """Teach numba the vectors; once a process."""
    global _registered
    if _registered:
        return
    _registered = True
    from llvmlite import ir
    from numba.core import cgutils, types
    from numba.core.datamodel import models
    from numba.core.typing.templates import AbstractTemplate, infer_global
    from numba.extending import lower_builtin, register_model

    bits = {"b1": 1, "u1": 8, "i2": 16, "i4": 32, "i8": 64}
    names = {"uint8": "u1", "int16": "i2", "int32": "i4", "int64": "i8", "float32": "f4"}

    class Vector(types.Type):
        """*lanes* elements of a kind: b1 (a mask), u1, i2, i4 or f4."""

        def __init__(self, kind: str, lanes: int) -> None:
            self.kind, self.lanes = kind, lanes
            super().__init__(name=f"Vector({kind} x {lanes})")

        @property
        def ir(self) -> Any:
            element = ir.FloatType() if self.kind == "f4" else ir.IntType(bits[self.kind])
            return ir.VectorType(element, self.lanes)

        def of(self, kind: str) -> Vector:
            return Vector(kind, self.lanes)

    @register_model(Vector)
    class Model(models.PrimitiveModel):
        def __init__(self, manager: Any, kind: Any) -> None:
            super().__init__(manager, kind, kind.ir)

    def kind_of(scalar: Any) -> str:
        return names[str(types.unliteral(scalar))]

    def pointer(context: Any, builder: Any, array_type: Any, array: Any, at: Any) -> Any:
        data = context.make_array(array_type)(context, builder, array).data
        return builder.gep(data, [at])

    def spread(builder: Any, scalar: Any, vector: Any) -> Any:
        """*scalar* in every lane of the type *vector*."""
        one = builder.insert_element(ir.Constant(vector, ir.Undefined), scalar, ir.IntType(32)(0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), vector.count), [0] * vector.count)
        return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), zeros)

    def index(context: Any, builder: Any, value: Any, kind: Any) -> Any:
        return context.cast(builder, value, kind, types.int64)

    def public(function: Any, *kinds: Any) -> Any:
        """Let numba compile *function* of *kinds* to what the function that follows makes.

        That function is given the types of the arguments; it returns the signature and what builds
        the code. numba's own @overload does the same at 20 ms a function.
        """

        def mark(make: Any) -> Any:
            class Template(AbstractTemplate):
                key = function
                prefer_literal = True

                def generic(self, arguments: Any, keywords: Any) -> Any:
                    made = make(None, *arguments)
                    return None if made is None else made[0]

            def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
                return make(None, *signature.args)[1](context, builder, signature, values)

            infer_global(function)(Template)
            lower_builtin(function, *(kinds or (types.VarArg(types.Any),)))(code)
            return make

        return mark

    @public(_lanes.load)
    def _load(typing: Any, array: Any, at: Any, lanes: Any) -> Any:
        made = Vector(names[str(array.dtype)], lanes.literal_value)

        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            place = index(context, builder, values[1], signature.args[1])
            start = pointer(context, builder, array, values[0], place)
            return builder.load(
                builder.bitcast(start, made.ir.as_pointer()), align=array.dtype.bitwidth // 8
            )

        return made(array, types.unliteral(at), lanes), code

    @public(_lanes.store)
    def _store(typing: Any, array: Any, at: Any, vector: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            place = index(context, builder, values[1], signature.args[1])
            start = pointer(context, builder, array, values[0], place)
            builder.store(
                values[2],
                builder.bitcast(start, vector.ir.as_pointer()),
                align=array.dtype.bitwidth // 8,
            )
            return context.get_dummy_value()

        return types.void(array, at, vector), code

    @public(_lanes.copy)
    def _copy(typing: Any, source: Any, at: Any, target: Any, to: Any, count: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            at, to, count = (index(context, builder, values[i], signature.args[i]) for i in (1, 3, 4))
            size = builder.mul(count, ir.IntType(64)(source.dtype.bitwidth // 8))
            cgutils.raw_memmove(
                builder,
                pointer(context, builder, target, values[2], to),
                pointer(context, builder, source, values[0], at),
                size,
                1,
            )
            return context.get_dummy_value()

        return types.void(source, at, target, to, count), code

    @public(_lanes.added)
    def _added(typing: Any, early: Any, late: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            kind = ir.FunctionType(early.ir, [early.ir, early.ir])
            name = f"llvm.sadd.sat.v{early.lanes}i16"
            return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), values)

        return early(early, late), code

    @public(_lanes.prefetch)
    def _prefetch(typing: Any, array: Any, at: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            flag, byte = ir.IntType(32), ir.IntType(8).as_pointer()
            kind = ir.FunctionType(ir.VoidType(), [byte, flag, flag, flag])
            hint = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
            place = index(context, builder, values[1], signature.args[1])
            where = builder.bitcast(pointer(context, builder, array, values[0], place), byte)
            builder.call(hint, [where, flag(0), flag(2), flag(1)])  # to read, into the second cache
            return context.get_dummy_value()

        return types.void(array, at), code

    @public(_lanes.splat)
    def _splat(typing: Any, value: Any, lanes: Any) -> Any:
        made = Vector(kind_of(value), lanes.literal_value)

        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return spread(builder, values[0], made.ir)

        return made(types.unliteral(value), lanes), code

    @public(_lanes.select)
    def _select(typing: Any, mask: Any, yes: Any, no: Any) -> Any:
        made = yes if isinstance(yes, Vector) else no
        wide = made if isinstance(made, Vector) else mask.of(kind_of(yes))

        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            both = [
                value if isinstance(kind, Vector) else spread(builder, value, wide.ir)
                for kind, value in zip(signature.args[1:], values[1:], strict=True)
            ]
            return builder.select(values[0], *both)

        return wide(mask, types.unliteral(yes), types.unliteral(no)), code

    @public(_lanes.shifted)
    def _shifted(typing: Any, vector: Any, first: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            n = vector.lanes
            before = spread(builder, values[1], vector.ir)
            places = ir.Constant(ir.VectorType(ir.IntType(32), n), list(range(n - 1, 2 * n - 1)))
            return builder.shuffle_vector(before, values[0], places)

        return vector(vector, types.unliteral(first)), code

    def conversion(function: Any, target: str, how: dict[str, str]) -> None:
        @public(function)
        def _convert(typing: Any, vector: Any) -> Any:
            made = vector.of(target)

            def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
                return getattr(builder, how[vector.kind])(values[0], made.ir)

            return made(vector), code

    conversion(_lanes.widened, "i2", {"u1": "zext"})
    conversion(_lanes.as_bytes, "u1", {"b1": "zext", "i4": "trunc"})
    conversion(_lanes.as_places, "i4", {"f4": "fptosi"})
    conversion(_lanes.as_floats, "f4", {"i4": "sitofp", "u1": "uitofp"})

    @public(_lanes.gather)
    def _gather(typing: Any, table: Any, places: Any) -> Any:
        made = places.of(names[str(table.dtype)])

        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            n = places.lanes
            long = ir.VectorType(ir.IntType(64), n)
            size = table.dtype.bitwidth // 8
            data = context.make_array(table)(context, builder, values[0]).data
            start = spread(builder, builder.ptrtoint(data, ir.IntType(64)), long)
            offset = builder.mul(builder.sext(values[1], long), ir.Constant(long, [size] * n))
            pointers = ir.VectorType(made.ir.element.as_pointer(), n)
            mask = ir.VectorType(ir.IntType(1), n)
            kind = ir.FunctionType(made.ir, [pointers, ir.IntType(32), mask, made.ir])
            element = "f32" if made.kind == "f4" else f"i{bits[made.kind]}"
            load = cgutils.get_or_insert_function(
                builder.module, kind, f"llvm.masked.gather.v{n}{element}.v{n}p0"
            )
            where = builder.inttoptr(builder.add(start, offset), pointers)
            every = ir.Constant(mask, [1] * n)
            return builder.call(
                load, [where, ir.IntType(32)(size), every, ir.Constant(made.ir, ir.Undefined)]
            )

        return made(table, places), code

    @public(_lanes.transpose)
    def _transpose(
        typing: Any, source: Any, at: Any, pitch: Any, target: Any, to: Any, step: Any
    ) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            n = _lanes.TILE
            line = ir.VectorType(ir.IntType(8), n)
            numbers = [index(context, builder, values[i], signature.args[i]) for i in (1, 2, 4, 5)]

            def place(array_type: Any, array: Any, start: Any, stride: Any, row: int) -> Any:
                where = builder.add(start, builder.mul(stride, ir.IntType(64)(row)))
                return builder.bitcast(
                    pointer(context, builder, array_type, array, where), line.as_pointer()
                )

            rows = [
                builder.load(place(source, values[0], numbers[0], numbers[1], r), align=1)
                for r in range(n)
            ]
            # log2(n) perfect shuffles of rows r and r + n/2 transpose n × n.
            halves = [
                ir.Constant(
                    ir.VectorType(ir.IntType(32), n),
                    [first + i // 2 + n * (i % 2) for i in range(n)],
                )
                for first in (0, n // 2)
            ]
            for _ in range(n.bit_length() - 1):
                rows = [
                    builder.shuffle_vector(rows[r], rows[r + n // 2], half)
                    for r in range(n // 2)
                    for half in halves
                ]
            for t in range(n):
                builder.store(rows[t], place(target, values[3], numbers[2], numbers[3], t), align=1)
            return context.get_dummy_value()

        return types.void(source, at, pitch, target, to, step), code

    @public(_lanes.acquire)
    def _acquire(typing: Any, array: Any, at: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            place = index(context, builder, values[1], signature.args[1])
            return builder.load_atomic(pointer(context, builder, array, values[0], place), "acquire", 8)

        return types.int64(array, at), code

    @public(_lanes.release)
    def _release(typing: Any, array: Any, at: Any, value: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            place = index(context, builder, values[1], signature.args[1])
            number = index(context, builder, values[2], signature.args[2])
            builder.store_atomic(
                number, pointer(context, builder, array, values[0], place), "release", 8
            )
            return context.get_dummy_value()

        return types.void(array, at, value), code

    def arithmetic(
        function: Any, whole: str | None, real: str | None, result: str | None = None
    ) -> None:
        def make(typing: Any, a: Any, b: Any) -> Any:
            vectors = [kind for kind in (a, b) if isinstance(kind, Vector)]
            if not vectors or (len(vectors) == 2 and a != b):
                return None
            vector = vectors[0]
            name = real if vector.kind == "f4" else whole
            mixed = vector.kind != "f4" and any(isinstance(kind, types.Float) for kind in (a, b))
            if name is None or mixed:
                return None
            made = vector.of(result) if result else vector

            def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
                both = []
                for kind, value in zip(signature.args, values, strict=True):
                    if not isinstance(kind, Vector):
                        element = vector.ir.element
                        if isinstance(element, ir.IntType):
                            value = builder.trunc(index(context, builder, value, kind), element)
                        value = spread(builder, value, vector.ir)
                    both.append(value)
                if result:
                    compare = builder.fcmp_ordered if vector.kind == "f4" else builder.icmp_signed
                    return compare(name, *both)
                return getattr(builder, name)(*both)

            return made(types.unliteral(a), types.unliteral(b)), code

        for kinds in ((Vector, Vector), (Vector, types.Number), (types.Number, Vector)):
            public(function, *kinds)(make)

    arithmetic(operator.add, "add", "fadd")
    arithmetic(operator.sub, "sub", "fsub")
    arithmetic(operator.mul, "mul", "fmul")
    arithmetic(operator.truediv, None, "fdiv")
    arithmetic(operator.rshift, "ashr", None)
    arithmetic(operator.lshift, "shl", None)
    arithmetic(operator.ge, ">=", ">=", "b1")
    arithmetic(operator.lt, "<", "<", "b1")
    arithmetic(operator.and_, "and_", None)
