"""User functions as callbacks of the engine: compiled ones directly, Python ones through cffi."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

FUNCTION: Any = ctypes.CFUNCTYPE(None).__mro__[1]  # base class of all ctypes functions
SIGNATURE = "int (*)(double, const double *, double *, void *)"


class BadAnswer(ValueError):
    """Error raised if a user's Python function does not return a force and a torque."""


def callback(ffi: Any, function: Any, raised: list[BaseException]) -> tuple[Any, Any, Any]:
    """Return a jo_callback, its user pointer and the objects that must stay alive.

    Parameters
    ----------
    ffi : FFI
        cffi's interface to the engine.
    function : callable
        A ctypes function, a numba cfunc, a `scipy.LowLevelCallable` with the signature of
        jo_callback, or a Python function of time, s, and x (18,) = [r_b - r_a, orientation
        (9, row-major), velocity, angular velocity] of b relative to a, resolved in a, that returns
        the force and torque (6,) on b, resolved in a.
    raised : list
        List to which exceptions of a Python function are appended.
    """
    user = ffi.NULL
    compiled: Any = function
    whole: Any = function
    if isinstance(function, tuple) and hasattr(function, "function"):  # scipy.LowLevelCallable
        compiled = whole.function
        if isinstance(whole.user_data, ctypes.c_void_p):
            user = ffi.cast("void *", whole.user_data.value or 0)
    if not isinstance(compiled, FUNCTION) and hasattr(compiled, "ctypes"):
        compiled = compiled.ctypes  # numba
    if isinstance(compiled, FUNCTION):
        address = ctypes.cast(compiled, ctypes.c_void_p).value
        return ffi.cast(SIGNATURE, address), user, function

    def call(time: float, x: Any, y: Any, _: Any) -> int:
        given = np.frombuffer(ffi.buffer(x, 144), dtype=np.float64).copy()
        answer = np.asarray(function(time, given), dtype=np.float64)
        if answer.shape != (6,):
            raise BadAnswer(f"returned an array of shape {answer.shape}, must be (6,)")
        if not np.isfinite(answer).all():
            k = int(np.argmin(np.isfinite(answer)))
            what = f"{'force' if k < 3 else 'torque'} {'xyz'[k % 3]} is {answer[k]}"
            raise BadAnswer(f"returned values that are not finite, {what}")
        np.frombuffer(ffi.buffer(y, 48), dtype=np.float64)[:] = answer
        return 0

    def failed(kind: Any, error: BaseException, trace: Any) -> int:
        del kind, trace
        raised.append(error)
        return 1

    pointer = ffi.callback(SIGNATURE, call, error=1, onerror=failed)
    return pointer, user, pointer
