"""The linking compiler of kernels, and how compiled code is kept between runs.

Numba takes a function through typing, LLVM's passes and machine code wherever it is called from,
and again inside each caller, because callees are linked into callers. Here a function has two
forms. `Kernel` is the entry that Python calls: it is compiled in full. Its form for compiled
callers goes no further than LLVM code, as it was written. The entry links, optimises and
translates the code of all that it reaches, once.

What else keeps the first run of a command short:

- What several entries reach can be shared: it has machine code of its own, in a file of its own,
  which entries call (`_Shared`).
- Tuples that hold arrays are passed by reference (`compiled_records.py`).
- A function is compiled once for arrays that may be written to and for read-only ones, and once
  for a number that stands in a call and for any other.
- How a call of one of numba's own functions was resolved is remembered (`_Typing`), and what is
  compiled of these serves callers of every kind (`_Flags`) and goes no further than LLVM code.
- Passes for what no kernel has are left out, and so are wrappers for C and the optimisation of
  wrappers for Python.

Numba keeps machine code on disk and trusts what it reads: a damaged file ends in an error of the
reader or in a crash. It also keeps the code until the function's own file changes, though the
code holds callees from other files. Here each file begins with a hash of its contents, of the
versions of the compiler, and of the code of the function and of all it refers to (`code_stamp`).
A file with another hash is not read: the function is compiled and kept again. A comment or a
docstring is no code. Where nothing can be written, nothing is kept.

A wheel can bring such files along (`tools/build_wheel.py`), compiled for the processors of the
level x86-64-v3. What is not kept yet is looked for among them.
"""

from __future__ import annotations

import gc
import hashlib
import pickle
import platform
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib import import_module
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, ClassVar

import llvmlite
import numba
import numpy as np
from llvmlite.binding import parse_assembly
from numba.core import ir, types
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache
from numba.core.cgutils import normalize_ir_text
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_machinery import register_pass
from numba.core.dispatcher import Dispatcher
from numba.core.registry import CPUDispatcher
from numba.core.runtime import rtsys
from numba.core.sigutils import normalize_signature
from numba.core.target_extension import CPU, jit_registry
from numba.core.targetconfig import ConfigStack
from numba.core.typed_passes import DumpParforDiagnostics, NativeLowering, NopythonRewrites
from numba.core.types.containers import BaseNamedTuple, BaseTuple
from numba.core.types.misc import unliteral
from numba.core.typing import Context
from numba.core.untyped_passes import (
    FindLiterallyCalls,
    InlineClosureLikes,
    LiteralPropagationSubPipelinePass,
    LiteralUnroll,
    RewriteDynamicRaises,
    WithLifting,
)

from workbench.compiled_records import RecordLowering, RecordTarget, with_records

__all__ = ["PACKAGE", "Kernel", "code_stamp"]

PACKAGE = Path(__file__).parent
WHOLE_FILES = (
    "compiled_linked.py",
    "compiled_records.py",
    "geometry/simd8.py",
    "geometry/simd4.py",
)
"""Files of which every byte counts: they change how all others are compiled."""
FOREIGN = {"builtins", "math", "operator", "numpy", "numba", "llvmlite"}
"""Packages whose functions are named in a stamp, not described."""
_DIGEST = hashlib.sha256().digest_size


# ---------------------------------------------------------------------------------- compiling


class _Flags(Flags):  # type: ignore[misc]
    """Compiler flags that are equal where they compile what a function calls of numba's own alike.

    Numba looks up each operator, and each function of its own that it has compiled, by a key that
    holds the flags of the caller. With its own flags `max` of two numbers is compiled anew for each
    kind of caller, and each comparison of flags makes two dictionaries of twenty values.
    """

    __slots__ = ()
    names = ("error_model", "nrt", "fastmath", "boundscheck", "debuginfo", "auto_parallel")

    def _key(self) -> tuple[Any, ...]:
        return tuple([self._values.get(name) for name in self.names])

    def __eq__(self, other: object) -> bool:
        return type(other) is _Flags and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key()[:2])


class _Typing(Context):  # type: ignore[misc]
    """Numba's typing context, which remembers how calls of its own functions were resolved.

    For each operator numba tries some ten templates, twice each, wherever it stands: a tenth of the
    compile time. Else it is the same context: it shares all that the other holds and equals it, so
    that what was compiled with either serves both.
    """

    known: ClassVar[dict[Any, Any]] = {}
    """Signatures by function, types of the arguments and flags."""

    def __init__(self, context: Context) -> None:
        object.__setattr__(self, "__dict__", vars(context))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Context) and vars(self) is vars(other)

    def __hash__(self) -> int:
        return id(vars(self))

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """The signature of a call."""
        if kws or not isinstance(func, types.Function):
            return super().resolve_function_type(func, args, kws)
        key = func, tuple(args), ConfigStack.top_or_none()
        found = self.known.get(key)
        if found is None:
            found = super().resolve_function_type(func, args, kws)
            self.known[key] = found
        return found


class _Compiler(CompilerBase):  # type: ignore[misc]
    """The compiler of entries: numba's own passes."""

    lowering: Any = None

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags = _Flags(self.state.flags)
        self.state.typingctx = _Typing(self.state.typingctx)
        self.state.targetctx = RecordTarget(self.state.targetctx)

    def define_pipelines(self) -> list[Any]:
        """The passes that these functions need, in one list."""
        instead = {
            NativeLowering: self.lowering,
            InlineClosureLikes: _InlineClosures,
            NopythonRewrites: _RewriteArrays,
        }
        return [self.passes(instead, _NEEDLESS)]

    def passes(self, instead: dict[Any, Any], needless: set[Any]) -> Any:
        """Numba's passes, some of them replaced or left out."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes._finalized = False
        passes._ENFORCING = False  # no analysis again after each pass: they see to it themselves
        passes.passes = [
            (instead.get(step, step), what) for step, what in passes.passes if step not in needless
        ]
        passes.finalize()
        return passes


_NEEDLESS = {WithLifting, RewriteDynamicRaises, FindLiterallyCalls, LiteralUnroll}
_NEEDLESS |= {LiteralPropagationSubPipelinePass, DumpParforDiagnostics}
"""Passes for what no kernel has: object mode, exceptions made on the way, literal_unroll, prange."""


@register_pass(mutates_CFG=True, analysis_only=False)
class _InlineClosures(InlineClosureLikes):  # type: ignore[misc]
    """Inline comprehensions and inner functions, where there are any."""

    def run_pass(self, state: Any) -> bool:
        """Look for code among the constants first."""
        constants = state.func_id.code.co_consts
        return any(isinstance(c, CodeType) for c in constants) and bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class _RewriteArrays(NopythonRewrites):  # type: ignore[misc]
    """Make one loop of an expression of whole arrays, where there is any."""

    def run_pass(self, state: Any) -> bool:
        """Look for what gives an array and is no index first."""
        found = any(
            call.op != "getitem" and isinstance(getattr(made, "return_type", None), types.Array)
            for call, made in state.calltypes.items()
            if isinstance(call, ir.Expr)
        )
        return found and bool(super().run_pass(state))


class _InnerCompiler(_Compiler):
    """The compiler of functions for compiled callers: it stops at LLVM code."""


class _LibraryCompiler(_Compiler):
    """The same for what kernels call of numba's own, which may need any pass."""

    def define_pipelines(self) -> list[Any]:
        """All passes, in one list."""
        return [self.passes({NativeLowering: _InnerLowering}, set())]


@register_pass(mutates_CFG=True, analysis_only=False)
class _EntryLowering(NativeLowering):  # type: ignore[misc]
    """Lower into a library that makes machine code."""

    _name = "entry_lowering"
    lowering_class = RecordLowering

    def run_pass(self, state: Any) -> bool:
        """Lower one function."""
        state.library = _EntryLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return bool(super().run_pass(state))


class _Library(JITCodeLibrary):  # type: ignore[misc]
    """LLVM code of functions that are given records."""

    def add_ir_module(self, module: Any) -> None:
        """Add a module; what is linked in the end is verified there."""
        code = parse_assembly(with_records(normalize_ir_text(str(module))))
        code.name = module.name
        self.add_llvm_module(code)

    def _optimize_functions(self, module: Any) -> None:
        """Leave it to the optimisation of the whole."""
        module.data_layout = self._codegen._data_layout


class _EntryLibrary(_Library):
    """LLVM code and machine code of a function with all that it calls."""

    def add_ir_module(self, module: Any) -> None:
        """Add the function, or the wrapper that takes apart what Python hands over.

        The wrapper of a function of a hundred arrays is larger than the function: it is not
        optimised.
        """
        for function in module.functions:
            if function.name.startswith("_ZN7cpython"):
                function.attributes.add("optnone")
                function.attributes.add("noinline")
        super().add_ir_module(module)

    def finalize(self) -> None:
        """Link all that is called, directly or not, each function once."""
        rest = []
        for library in _reached(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            if isinstance(library, _InnerLibrary):
                library.link_into(self)
            elif not _is_shared(library):
                rest.append(library)
        self._linking_libraries: list[Any] = rest
        super().finalize()

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Keep the machine code and the names in it: no caller links the LLVM code of an entry."""
        self._ensure_finalized()
        names = [one.name for one in self._final_module.functions if not one.is_declaration]
        named = parse_assembly("\n".join(f'@"{name}" = global i8 0' for name in names))
        return self.name, "object", (self._get_compiled_object(), named.as_bitcode())

    def _optimize_final_module(self) -> None:
        """Optimise once: numba does it twice where references are counted."""
        manager, builder = self._codegen._module_pass_manager()
        manager.run(self._final_module, builder)


def _reached(libraries: list[Any]) -> list[Any]:
    """Libraries and those that they call, directly or not, each once."""
    found = dict.fromkeys(libraries)
    waiting = list(found)
    while waiting:
        library = waiting.pop()
        if isinstance(library, _InnerLibrary):
            new = [called for called in library._linking_libraries if called not in found]
            found.update(dict.fromkeys(new))
            waiting += new
    return list(found)


@register_pass(mutates_CFG=True, analysis_only=False)
class _InnerLowering(NativeLowering):  # type: ignore[misc]
    """Lower into a library that callers link."""

    _name = "inner_lowering"
    lowering_class = RecordLowering

    def run_pass(self, state: Any) -> bool:
        """Lower one function."""
        state.library = _InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        return bool(super().run_pass(state))


class _InnerLibrary(_Library):
    """LLVM code of one function, without its callees and without machine code."""

    @property
    def codegen(self) -> _NoEnvironment:
        """What sets the function's environment: a function without machine code has none."""
        return _NoEnvironment()

    def get_pointer_to_function(self, name: str) -> int:
        """0: Python cannot call this function."""
        self._ensure_finalized()
        return 0

    def finalize(self) -> None:
        """Link nothing: the entry links each function that it reaches, once."""
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        self._finalize_dynamic_globals()
        for function in self._final_module.functions:
            if not function.is_declaration:
                function.linkage = "linkonce_odr"
        self._shared_module = self._final_module
        self._finalized = True

    def link_into(self, library: Any) -> None:
        """Link this function into a library, without its callees."""
        self._ensure_finalized()
        library._final_module.link_in(self._shared_module, preserve=True)

    def _get_module_for_linking(self) -> Any:
        """Hand out the function with all that it calls, to callers that numba compiles by itself: a
        user's own, which share with these what is compiled of numba's functions."""
        self._ensure_finalized()
        whole = self._shared_module.clone()
        for library in _reached(self._linking_libraries):
            if _is_shared(library):
                continue
            own = isinstance(library, _InnerLibrary)
            module = library._shared_module if own else library._get_module_for_linking()
            whole.link_in(module, preserve=True)
        return whole


class _SharedLibrary(_EntryLibrary):
    """LLVM code and machine code of a function with all that it calls, for compiled callers."""

    @property
    def codegen(self) -> _NoEnvironment:
        """What sets the function's environment: only what Python calls has one."""
        return _NoEnvironment()


def _is_shared(library: Any) -> bool:
    """Whether callers find a library's machine code by its name, and link nothing."""
    return getattr(library, "is_shared", False)


class _NoEnvironment:
    def set_env(self, name: str, environment: object) -> None:
        """Set nothing."""


class _SharedCompiler(_Compiler):
    """The compiler of functions that several entries call."""


@register_pass(mutates_CFG=True, analysis_only=False)
class _SharedLowering(NativeLowering):  # type: ignore[misc]
    """Lower into a library that makes machine code for compiled callers."""

    _name = "shared_lowering"
    lowering_class = RecordLowering

    def run_pass(self, state: Any) -> bool:
        """Lower one function."""
        state.library = _SharedLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return bool(super().run_pass(state))


_Compiler.lowering = _EntryLowering
_SharedCompiler.lowering = _SharedLowering
_InnerCompiler.lowering = _InnerLowering


class _Called(CPUDispatcher):  # type: ignore[misc]
    """A compiled function that compiled code calls, and Python never does."""

    def compile(self, sig: Any) -> Any:
        """Compile for one tuple of types, unless that is done.

        Numba would begin two clocks here, and tell each clock of all callers about every step.
        """
        given, _ = normalize_signature(sig)
        if given not in self.overloads:
            with self._compiling_counter:
                self.add_overload(self._compiler.compile(given, None))
        return self.overloads[given].entry_point


class _Inner(_Called):
    """A kernel: what compiled callers see."""

    def compile(self, sig: Any) -> Any:
        """Compile for one tuple of types; a number that stands in the call counts as any other."""
        given, _ = normalize_signature(sig)
        return super().compile(tuple(unliteral(kind) for kind in given))


@dataclass(frozen=True)
class _Load:
    """What makes a shared function ready before code that calls it is loaded: kept with that."""

    module: str
    name: str
    types: tuple[Any, ...]

    def __call__(self) -> None:
        """Load or compile it."""
        getattr(import_module(self.module), self.name).inner.compile(self.types)


class _Shared(_Inner):
    """A kernel that several entries call: its machine code is made once and kept by itself.

    Callers know it by a name that is the same in all processes (`RecordTarget.mangler`).
    """

    def __init__(self, kernel: Kernel, options: dict[str, Any]) -> None:
        super().__init__(kernel.py_func, kernel.locals, options, _SharedCompiler)
        self.files = kernel.kept("shared")
        RecordTarget.shared_names.add(f"{self.py_func.__module__}.{self.py_func.__qualname__}")

    def compile(self, sig: Any) -> Any:
        """Load or compile for one tuple of types, unless that is done."""
        given = tuple(unliteral(kind) for kind in normalize_signature(sig)[0])
        if given not in self.overloads:
            result = self.files.load_overload(given, self.targetctx)
            if result is None:
                with self._compiling_counter:
                    result = self._compiler.compile(given, None)
                self.files.save_overload(given, result)
            else:
                code = [result.library]
                self.targetctx.insert_user_function(result.entry_point, result.fndesc, code)
            result.library.is_shared = True
            load = _Load(self.py_func.__module__, self.py_func.__name__, given)
            result.library._reload_init.add(load)
            self.add_overload(result)
        return self.overloads[given].entry_point


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A compiled function: what Python calls. Compiled callers are given `inner`."""

    is_shared = False

    def __init__(
        self,
        py_func: Callable[..., Any],
        local_types: dict[str, Any] | None = None,
        targetoptions: dict[str, Any] | None = None,
        pipeline_class: type[CompilerBase] = _Compiler,
    ) -> None:
        options = dict(targetoptions or {})
        entry = options | {"no_cfunc_wrapper": True}
        super().__init__(py_func, local_types or {}, entry, pipeline_class)

    def share(self) -> None:
        """Have one machine code for all compiled callers."""
        self.is_shared = True

    @cached_property
    def _cache(self) -> Any:
        """Where machine code is kept. Most kernels are never called by Python and need none."""
        return self.kept("")

    def kept(self, form: str) -> Any:
        """Where machine code of a form is kept."""
        try:
            return _Cache(self, form)
        except RuntimeError:  # no folder can be written to
            return NullCache()

    @cached_property
    def inner(self) -> _Inner:
        """What compiled callers call, made where one is compiled."""
        options = self.targetoptions | {"no_cpython_wrapper": True}
        if self.is_shared:
            return _Shared(self, options)
        return _Inner(self.py_func, self.locals, options, _InnerCompiler)

    @property
    def _numba_type_(self) -> types.Dispatcher:
        """What compiled code sees where it names this function."""
        return types.Dispatcher(self.inner)

    def compile(self, sig: Any) -> Any:
        """Compile for one tuple of types, or read what was compiled before.

        Read-only arrays are taken as any other, so that a function is compiled once for both. What
        writes to its arguments says so in its docstring; without the compiler a wrong write fails.
        """
        given, _ = normalize_signature(sig)
        plain = tuple(_writable(kind) for kind in given)
        with _no_collection(), _inner_library():
            entry = super().compile(plain)
        if plain != given and given not in self.overloads:
            result = self.overloads[plain]
            self.overloads[given] = result
            self._insert([kind._code for kind in given], entry, result.objectmode)
        return entry


@contextmanager
def _inner_library() -> Iterator[None]:
    """Compile numba's own functions, `np.empty` and `max` and their like, as far as LLVM code
    meanwhile: only compiled code calls them."""
    usual = jit_registry[CPU]
    dict.__setitem__(jit_registry, CPU, _library_function)
    try:
        yield
    finally:
        dict.__setitem__(jit_registry, CPU, usual)


def _library_function(*function: Any, **options: Any) -> Any:
    """What `numba.jit` makes of a function of numba's own, without machine code."""
    options |= {"nopython": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}

    def compiled(py_func: Any) -> CPUDispatcher:
        return _Called(py_func, {}, options, _LibraryCompiler)

    return compiled(*function) if function else compiled


def _writable(kind: Any) -> Any:
    """A type with all arrays in it writable."""
    if isinstance(kind, types.Array):
        return kind if kind.mutable else kind.copy(readonly=False)
    if isinstance(kind, BaseNamedTuple):
        fields = [_writable(field) for field in kind]
        return BaseTuple.from_types(fields, kind.instance_class)
    if isinstance(kind, BaseTuple):
        return BaseTuple.from_types([_writable(field) for field in kind])
    return kind


@contextmanager
def _no_collection() -> Iterator[None]:
    """Collect no garbage meanwhile: the compiler makes millions of small objects and keeps most."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


# ------------------------------------------------------------------------------------ stamps


def code_stamp(function: Any) -> bytes:
    """Hash the code of a function and of everything that it refers to, and what compiles it.

    Parameters
    ----------
    function : Kernel or function
        Its code, options, default values and the values of its global names count. Functions
        among these count in the same way, to any depth. Comments, docstrings, line numbers and
        the times of files do not.

    Returns
    -------
    bytes
        32 bytes.

    Raises
    ------
    TypeError
        If a name stands for a value whose contents cannot be told.
    """
    lines: list[str] = []
    _describe(function, lines, {})
    digest = hashlib.sha256(_compiler_stamp())
    digest.update("\n".join(lines).encode())
    return digest.digest()


@lru_cache(maxsize=1)
def _compiler_stamp() -> bytes:
    digest = hashlib.sha256(" ".join([*platform.python_version_tuple()[:2], *_versions()]).encode())
    for name in WHOLE_FILES:
        digest.update(hashlib.sha256((PACKAGE / name).read_bytes()).digest())
    return digest.digest()


def _versions() -> list[str]:
    """Of numpy the layout of arrays counts alone, which no patch changes."""
    return [numba.__version__, llvmlite.__version__, np.__version__.rpartition(".")[0]]


def _describe(value: Any, lines: list[str], seen: dict[int, int]) -> None:
    """Add what a value is to a list of lines; values met before are told by their number."""
    if id(value) in seen:
        lines.append(f"again {seen[id(value)]}")
        return
    if _foreign(value):
        lines.append(f"{value.__module__}.{value.__qualname__}")
    elif isinstance(value, Dispatcher):
        seen[id(value)] = len(seen)
        form = " shared" if getattr(value, "is_shared", False) else ""
        lines.append(f"compiled{form} {sorted(value.targetoptions.items())!r}")
        _describe(value.py_func, lines, seen)
    elif isinstance(value, FunctionType):
        seen[id(value)] = len(seen)
        _describe_function(value, lines, seen)
    elif isinstance(value, tuple | list):
        lines.append(f"{type(value).__qualname__} of {len(value)}")
        for item in value:
            _describe(item, lines, seen)
    elif isinstance(value, np.ndarray):
        contents = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        lines.append(f"array {value.dtype.str} {value.shape} {contents}")
    elif isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields"):
        fields = value._fields, vars(value).get("_field_defaults")
        lines.append(f"{value.__module__}.{value.__qualname__} {fields}")
    elif isinstance(value, ModuleType):
        lines.append(f"module {value.__name__}")
    elif _plain(value):
        lines.append(f"{type(value).__qualname__} {value!r}")
    else:
        raise TypeError(f"compiled code refers to {value!r}, whose contents cannot be told")


def _plain(value: object) -> bool:
    numbers = (int, float, complex, np.generic)
    return isinstance(value, (*numbers, str, bytes, type(None), np.dtype, types.Type))


def _foreign(value: object) -> bool:
    """Whether a value is a function or class of the compiler's own world: its version counts."""
    home = str(getattr(value, "__module__", "")).partition(".")[0]
    return home in FOREIGN and hasattr(value, "__qualname__")


def _describe_function(function: FunctionType, lines: list[str], seen: dict[int, int]) -> None:
    lines.append(f"function {function.__module__}.{function.__qualname__}")
    names = _describe_code(function.__code__, function.__doc__, lines)
    _describe(function.__defaults__, lines, seen)
    for cell in function.__closure__ or ():
        _describe(cell.cell_contents, lines, seen)
    for name in sorted(names & function.__globals__.keys()):
        value = function.__globals__[name]
        lines.append(name)
        _describe(value, lines, seen)
        if isinstance(value, ModuleType) and value.__name__.startswith("workbench"):
            for attribute in sorted(names & vars(value).keys()):
                lines.append(attribute)
                _describe(vars(value)[attribute], lines, seen)


def _describe_code(code: CodeType, doc: str | None, lines: list[str]) -> set[str]:
    """Add byte code and constants to the lines; returns all names in it."""
    names = set(code.co_names)
    # Numba's dispatcher masks the flags of what it calls under a profiler by 0xFFFE, for good. The
    # bits that this loses, CO_OPTIMIZED and the future statements, change no machine code.
    flags = code.co_flags & 0xFFFE
    shape = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, flags)
    variables = (code.co_varnames, code.co_cellvars, code.co_freevars)
    lines.append(f"{shape} {code.co_names} {variables} {code.co_code.hex()}")
    lines.append(getattr(code, "co_exceptiontable", b"").hex())
    for place, constant in enumerate(code.co_consts):
        if isinstance(constant, CodeType):
            names |= _describe_code(constant, None, lines)
        elif place == 0 and doc is not None and isinstance(constant, str):
            lines.append("docstring")
        else:
            lines.append(f"{type(constant).__qualname__} {constant!r}")
    return names


# ------------------------------------------------------------------------------------- files


Key = tuple[Any, Any, Any]
"""What compiled code is for: the types of arguments, the machine, hashes of the byte code."""
ADDRESS = re.compile(r" at 0x[0-9a-f]+")
"""Where an object of this process lies, which is elsewhere in the next."""


SHIPPED = PACKAGE / "machine_code"
"""Where a wheel has machine code, if it has any."""
LEVEL = "x86-64-v3"
LEVEL_FEATURES = "+avx2,+bmi,+bmi2,+f16c,+fma,+lzcnt,+movbe,+popcnt"
"""What the machine code of a wheel may use of a processor, and what this must have at least."""


class _Cache(FunctionCache):  # type: ignore[misc]
    """The compiled code of one function, for all types of arguments that it was compiled for."""

    def __init__(self, kernel: Kernel, form: str) -> None:
        super().__init__(kernel.py_func)
        # no line number: a comment above the function would change it
        line = f"-{kernel.py_func.__code__.co_firstlineno}."
        name = self._impl.filename_base.replace(line, f".{form}." if form else ".")
        self._cache_file = _Files(self._cache_path, name, kernel)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The code for types of arguments, where it is kept.

        Numba would first load all that it can compile, SciPy with it, as `CompilerBase` does again
        where something is to be compiled. To run what is kept takes the runtime of arrays alone.
        """
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


class _Files(IndexDataCacheFile):  # type: ignore[misc]
    """The compiled code of one function, a checked file for each kind of arguments.

    A file is named by the arguments' types. There is no index of the files: two processes that
    write one index at the same time would lose each other's entries.
    """

    def __init__(self, folder: str, name: str, kernel: Kernel) -> None:
        super().__init__(folder, name, b"")
        self._name = name
        self._kernel = kernel
        self._stamp: bytes | None = None

    def load(self, key: Key) -> Any:
        """The code for a key; None where there is none that can be believed."""
        found = self._kept(self._path(key), key)
        triple, _, features = key[1]
        if found is None and set(LEVEL_FEATURES.split(",")) <= set(features.split(",")):
            level = (key[0], (triple, LEVEL, LEVEL_FEATURES), *key[2:])
            found = self._kept(str(SHIPPED / Path(self._path(level)).name), level)
        return found

    def _kept(self, path: str, key: Key) -> Any:
        """The code for a key in a file; None where there is none that can be believed."""
        data = self._contents(path)
        if data is None:
            return None
        kept, code = pickle.loads(data)
        return code if kept == key else None

    def save(self, key: Key, data: object) -> None:
        """Keep the code for a key, where the disk lets us."""
        with suppress(OSError):
            self._write(self._path(key), (key, data))

    def _path(self, key: Key) -> str:
        """The file of the code for a key: for the types of arguments and the machine."""
        types_of_arguments, machine = key[:2]
        described = ADDRESS.sub("", f"{types_of_arguments} {machine}")
        number = hashlib.sha256(described.encode()).hexdigest()[:16]
        path: str = self._data_path(f"{self._name}.{number}.nbc")
        return path

    def _contents(self, path: str) -> bytes | None:
        """What a file holds after its hash; None where the hash is another one."""
        try:
            data = Path(path).read_bytes()
        except OSError:
            return None
        return data[_DIGEST:] if data[:_DIGEST] == self._sealed(data[_DIGEST:]) else None

    def _write(self, path: str, held: object) -> None:
        data = self._dump(held)
        with self._open_for_write(path) as file:
            file.write(self._sealed(data) + data)

    def _sealed(self, data: bytes) -> bytes:
        """The hash that a file of such contents begins with."""
        if self._stamp is None:  # not before all that the function names is there
            self._stamp = code_stamp(self._kernel)
        return hashlib.sha256(self._stamp + data).digest()
