"""Records of arrays that compiled functions take by reference.

numba hands a named tuple over by value, and an array as seven words: the state of a run is some 270 arguments of every function that it
is given to.  Writing and reading such code was most of the time that a variant took to compile.  A record marked by ``by_reference`` is one
pointer to a table, which the call from Python fills and which does not change while the call lasts; compiled code reads from it only what
it uses.  What compiled code makes itself is a plain named tuple, by value.

The arrays belong to the caller in Python: compiled code may change their elements but must not return them.
"""

# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

import hashlib
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import NativeValue, infer_getattr, lower_getattr_generic, models, register_model, typeof_impl, unbox

from sph.solver.compiled.numba_internals import describe_array


class Record(types.Type):
    """Type of a record by the class of the named tuple and the types of its fields.

    Its name, which stands in that of every function compiled for it, is short.
    """

    def __init__(self, record: type, members: tuple[Any, ...]) -> None:
        self.instance_class = record
        self.fields: tuple[str, ...] = record._fields  # type: ignore[attr-defined]
        self.types = members
        text = "\n".join((record.__module__, record.__qualname__, *self.fields, *(repr(member.key) for member in members)))
        super().__init__(f"{record.__name__}:{hashlib.sha256(text.encode()).hexdigest()[:16]}")


def by_reference(record: Any) -> Any:
    """Mark a class of named tuples: compiled functions take its instances by reference."""

    @typeof_impl.register(record)
    def _type_of(value: Any, context: Any) -> Record:
        return Record(record, tuple(typeof_impl(each, context) for each in value))

    return record


register_model(Record)(models.OpaqueModel)


@infer_getattr
class _Fields(AttributeTemplate):
    key = Record

    def generic_resolve(self, record: Record, name: str) -> Any:  # type: ignore[override]
        return dict(zip(record.fields, record.types, strict=True)).get(name)


def _table(context: Any, record: Record) -> ir.Type:
    return ir.LiteralStructType(
        [context.get_value_type(member) if isinstance(member, types.Array) else context.get_data_type(member) for member in record.types]
    )


def _place(builder: Any, table: Any, *way: int) -> Any:
    return builder.gep(table, [ir.IntType(32)(0), *(ir.IntType(32)(index) for index in way)])


def _read(context: Any, builder: Any, kind: Any, place: Any) -> Any:
    """The value at a place of a table.

    Loads are marked as constant: else every write to an array could change the table, and loops would not vectorise.
    """
    if isinstance(kind, types.BaseTuple):
        return context.make_tuple(
            builder,
            kind,
            [_read(context, builder, each, _place(builder, place, index)) for index, each in enumerate(kind.types)],  # type: ignore[attr-defined]
        )
    model = context.data_model_manager[kind]
    if isinstance(kind, types.Array):
        array = cgutils.get_null_value(model.get_value_type())  # belongs to nobody here
        for name in ("nitems", "itemsize", "data", "shape", "strides"):
            inside = _place(builder, place, model.get_field_position(name))
            member = model.get_type(name)
            array = model.set(builder, array, _read(context, builder, member, inside), name)
        return array
    loaded = builder.load(place)
    loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return model.from_data(builder, loaded)


@lower_getattr_generic(Record)
def _field(context, builder, record, table, name):  # type: ignore[no-untyped-def]
    table = builder.bitcast(table, _table(context, record).as_pointer())
    index = record.fields.index(name)
    return _read(context, builder, record.types[index], _place(builder, table, index))


@unbox(Record)
def _from_python(record, value, c):  # type: ignore[no-untyped-def]
    """Fill a table on the stack of the call from Python."""
    builder = c.builder
    table = cgutils.alloca_once(builder, _table(c.context, record))
    failed = cgutils.false_bit
    for index, member in enumerate(record.types):
        item, place = c.pyapi.tuple_getitem(value, index), _place(builder, table, index)
        if isinstance(member, types.Array):
            wrong = cgutils.is_not_null(builder, describe_array(c, item, place))
        else:
            native = c.unbox(member, item)
            assert native.cleanup is None, f"{record}: {member} cannot be taken by reference"
            builder.store(c.context.data_model_manager[member].as_data(builder, native.value), place)
            wrong = native.is_error
        failed = builder.or_(failed, wrong)
    # An empty instruction between writing and reading: nothing is known of the table after it, so that its loads may count as constant.
    pointer = builder.bitcast(table, c.pyapi.voidptr)
    known = builder.asm(ir.FunctionType(pointer.type, [pointer.type]), "", "=r,0,~{memory}", [pointer], side_effect=True)
    return NativeValue(known, is_error=failed)
