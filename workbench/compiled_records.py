"""How tuples that hold arrays are passed between compiled functions: by reference.

Numba describes an array by seven numbers and more, takes a tuple apart into the numbers of all its
arrays, and passes each as an argument by itself. A tuple of a hundred arrays makes a thousand
arguments: a thousand instructions in each caller and a thousand in the function itself, each of
which names the type of the whole, which is as long. Most of the compiler's time went there.

Here such a tuple is a record. It lies in memory and is passed as one pointer, and its type has a
name. A field is read from where it lies. A tuple never changes, so it is copied only where that
place might be used again before the value is no longer needed:

- A place is steady while a value is read from it: an argument, a tuple that was put together, what
  a function returned, and a field of these.
- A variable with a single assignment, which is passed on every way to each of its uses, stands for
  the place of the value itself. Every other variable has a place of its own, and holds a copy.

Functions that count references (they make arrays) hold copies in all their variables.
"""

from __future__ import annotations

import re
from collections import Counter
from functools import cached_property
from typing import Any, ClassVar

from llvmlite import ir
from llvmlite.ir.values import ArgumentAttributes
from numba.core import cgutils, datamodel, types
from numba.core.analysis import compute_cfg_from_blocks, compute_use_defs
from numba.core.callconv import RETCODE_OK, CPUCallConv
from numba.core.cpu import CPUContext
from numba.core.datamodel.models import TupleModel
from numba.core.ir import Assign
from numba.core.lowering import Lower
from numba.core.types.containers import BaseTuple, NamedTuple, Tuple

__all__ = ["RecordLowering", "RecordTarget", "with_records"]

_INDEX = ir.IntType(32)
_SIZE = ir.IntType(64)

# ------------------------------------------------------------------------------------- types


class _RecordType(ir.IdentifiedStructType):  # type: ignore[misc]
    """The type of a record in LLVM code."""

    _size = 0

    def get_abi_size(self, target_data: Any, context: ir.Context | None = None) -> int:
        """Its size [B] in memory."""
        if not self._size:
            self._size = super().get_abi_size(target_data, context=_CONTEXT)
        return self._size


_CONTEXT = ir.Context()
"""All record types by their names. Modules are of another context, where nobody prints them all."""
_RECORDS: dict[str, _RecordType] = {}
"""Record types by the types of their fields."""
_DECLARATIONS: dict[str, str] = {}
"""Declarations of record types by their names in LLVM code."""
_NAME = re.compile(r'%"record\d+"')


def _record_type(fields: tuple[Any, ...]) -> _RecordType:
    """The type of records of such fields."""
    key = ", ".join(map(str, fields))
    if key not in _RECORDS:
        made = _RecordType(_CONTEXT, f"record{len(_RECORDS)}")
        made.set_body(*fields)
        _RECORDS[key] = _CONTEXT.identified_types[made.name] = made
        _DECLARATIONS[str(made)] = made.get_declaration()
    return _RECORDS[key]


def with_records(code: str) -> str:
    """Declare the record types that LLVM code names.

    Parameters
    ----------
    code : str
        The text of a module. An empty line stands between its head and its functions.

    Returns
    -------
    str
        The text with the declarations after the head.
    """
    found: dict[str, str] = {}
    waiting = [code]
    while waiting:
        new = set(_NAME.findall(waiting.pop())) - found.keys()
        found |= {name: _DECLARATIONS[name] for name in new}
        waiting += [_DECLARATIONS[name] for name in new]
    head, gap, functions = code.partition("\n\n")
    return "\n".join([head, *found.values(), gap, functions])


class _Record(TupleModel):  # type: ignore[misc]
    """What LLVM code makes of a tuple that holds arrays."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind)
        self.record = _record_type(tuple(model.get_value_type() for model in self._models))

    def get_value_type(self) -> _RecordType:
        """The record."""
        return self.record

    def get_data_type(self) -> _RecordType:
        """The record, in memory as anywhere."""
        return self.get_value_type()

    def get_argument_type(self) -> ir.PointerType:
        """A pointer to it."""
        return self.get_value_type().as_pointer()

    def as_argument(self, builder: Any, value: Any) -> Any:
        """Where a value lies, or a copy."""
        place = _steady_place(value)
        if place is None:
            place = _new_place(builder, value.type)
            builder.store(value, place)
        return place

    def from_argument(self, builder: Any, value: Any) -> Any:
        """Read an argument. The caller does not write to its place during the call."""
        value.steady = True
        return builder.load(value)

    def as_data(self, builder: Any, value: Any) -> Any:
        """The value itself."""
        return value

    from_data = as_data
    as_return = as_data
    from_return = as_data

    def load_from_data_pointer(self, builder: Any, ptr: Any, align: int | None = None) -> Any:
        """Read a value."""
        return builder.load(ptr)


def _holds_arrays(kind: Any) -> bool:
    if isinstance(kind, BaseTuple):
        return any(_holds_arrays(field) for field in kind)
    return isinstance(kind, types.Array)


def _model_of_tuple(manager: Any, kind: Any) -> TupleModel:
    return (_Record if _holds_arrays(kind) else TupleModel)(manager, kind)


_MODELS = datamodel.DataModelManager().chain(datamodel.default_manager)
_MODELS.register(NamedTuple, _model_of_tuple)
_MODELS.register(Tuple, _model_of_tuple)


# ------------------------------------------------------------------------------------ places


def _new_place(builder: Any, kind: Any) -> Any:
    """A place on the stack that is written to once, where the value is made."""
    with builder.goto_entry_block():
        place = builder.alloca(kind)
    place.steady = True
    return place


def _steady_place(value: Any) -> Any:
    """Where a value was read from, if it lies there as long as it is needed; else None."""
    place = value.operands[0] if isinstance(value, ir.LoadInstr) else None
    return place if getattr(place, "steady", False) else None


def _is_record(value: Any) -> bool:
    return isinstance(value.type, _RecordType)


def _field(builder: Any, place: Any, path: list[int]) -> Any:
    """The place of a field."""
    indices = [ir.Constant(_INDEX, i) for i in (0, *path)]
    return builder.gep(place, indices, inbounds=True)


def _write(context: Any, builder: Any, value: Any, place: Any) -> None:
    """Write a value to a place; a record is copied as memory."""
    source = _steady_place(value) if _is_record(value) else None
    if source is None:
        builder.store(value, place)
        return
    size = context.get_abi_sizeof(value.type)
    cgutils.raw_memcpy(builder, place, source, ir.Constant(_SIZE, 1), size, align=8)


class _Builder(ir.IRBuilder):  # type: ignore[misc]
    """Builder of functions that count no references."""

    def extract_value(self, agg: Any, idx: Any, name: str = "") -> Any:
        """Read a field from where it lies; take it out of the value where that is not known."""
        place = _steady_place(agg)
        if place is None:
            return super().extract_value(agg, idx, name)
        field = _field(self, place, list(idx) if isinstance(idx, list | tuple) else [idx])
        field.steady = True
        return self.load(field)


# ---------------------------------------------------------------------------------- lowering


_NOT_KEPT = "captures(none)" if "captures(none)" in ArgumentAttributes._known else "nocapture"
"""The attribute of a pointer that the function does not keep: LLVM gave it another name."""


class _CallConv(CPUCallConv):  # type: ignore[misc]
    """Numba's calls, with records as pointers."""

    def decorate_function(
        self, fn: Any, args: Any, fe_argtypes: Any, noalias: bool = False
    ) -> None:
        """Name the arguments; nobody writes to a record."""
        super().decorate_function(fn, args, fe_argtypes, noalias)
        for argument in self.get_arguments(fn):
            kind = argument.type
            if isinstance(kind, ir.PointerType) and isinstance(kind.pointee, _RecordType):
                argument.add_attribute("noalias")
                argument.add_attribute(_NOT_KEPT)
                set.add(argument.attributes, "readonly")  # which llvmlite does not know

    def return_value(self, builder: Any, retval: Any) -> None:
        """Write what is returned to where the caller wants it."""
        _write(self.context, builder, retval, self._get_return_argument(builder.function))
        self._return_errcode_raw(builder, RETCODE_OK)

    def call_function(
        self, builder: Any, callee: Any, resty: Any, argtys: Any, args: Any, attrs: Any = None
    ) -> Any:
        """Call a function; what it returns lies in a place of this call."""
        status, value = super().call_function(builder, callee, resty, argtys, args, attrs)
        if _is_record(value) and isinstance(value, ir.LoadInstr):
            value.operands[0].steady = True
        return status, value


class RecordTarget(CPUContext):  # type: ignore[misc]
    """Numba's target, with records: it shares all that the other holds but the types of tuples."""

    shared_internal: ClassVar[dict[Any, Any]] = {}
    """What numba has compiled of its own for this target."""
    shared_names: ClassVar[set[str]] = set()
    """Functions whose machine code other processes call by its name."""

    def __init__(self, context: CPUContext) -> None:
        self.__dict__.update(vars(context))
        self.data_model_manager = _MODELS
        self.cached_internal_func = self.shared_internal

    def mangler(self, name: str, types: Any, *, abi_tags: Any = (), uid: int | None = None) -> str:
        """The name of compiled code; numba numbers functions as they come, in each process anew."""
        number = None if name in self.shared_names else uid
        found: str = super().mangler(name, types, abi_tags=abi_tags, uid=number)
        return found

    @property
    def call_conv(self) -> _CallConv:
        """How functions are called."""
        return _CallConv(self)

    def make_tuple(self, builder: Any, typ: Any, values: Any) -> Any:
        """Put a tuple together, a record in its place."""
        kind = self.get_value_type(typ)
        if not isinstance(builder, _Builder) or not isinstance(kind, _RecordType):
            return super().make_tuple(builder, typ, values)
        place = _new_place(builder, kind)
        for i, value in enumerate(values):
            _write(self, builder, value, _field(builder, place, [i]))
        return builder.load(place)


class RecordLowering(Lower):  # type: ignore[misc]
    """Lowering of functions that are given records."""

    def setup_function(self, fndesc: Any) -> None:
        """Begin a function."""
        super().setup_function(fndesc)
        if not self.context.enable_nrt:
            self.builder = _Builder(self.entry_block)
            self.call_helper = self.call_conv.init_call_helper(self.builder)

    @cached_property
    def settled(self) -> set[str]:
        """The variables that need no place of their own."""
        return _settled(self.blocks)

    def alloca_lltype(self, name: str, lltype: Any, datamodel: Any = None) -> Any:
        """Make a place for a variable. Numba would work out its size, for a debugger."""
        return cgutils.alloca_once(self.builder, lltype, name=name)

    def storevar(self, value: Any, name: str, argidx: int | None = None) -> None:
        """Assign to a variable."""
        if self.context.enable_nrt or name in self._singly_assigned_vars:
            super().storevar(value, name, argidx)
            return
        place = _steady_place(value) if _is_record(value) else None
        if place is not None and name in self.settled and name not in self.varmap:
            self.varmap[name] = place
            return
        self._alloca_var(name, self.typeof(name))
        _write(self.context, self.builder, value, self.getvar(name))

    def delvar(self, name: str) -> None:
        """Count a reference less, where they are counted."""
        if self.context.enable_nrt:
            super().delvar(name)


def _settled(blocks: dict[int, Any]) -> set[str]:
    """Variables with one assignment, which is passed on every way to each of their uses."""
    assigned = {
        block: [found.target.name for found in blocks[block].find_insts(Assign)] for block in blocks
    }
    count = Counter(name for names in assigned.values() for name in names)
    home = {name: block for block, names in assigned.items() for name in names if count[name] == 1}
    above = compute_cfg_from_blocks(blocks).dominators()
    # what a block uses before it assigns to it
    for block, names in compute_use_defs(blocks).usemap.items():
        for name in names & home.keys():
            if home[name] == block or home[name] not in above[block]:
                del home[name]
    return set(home)
