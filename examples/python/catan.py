"""The client's part of Catan's C ABI (catan/catan.h), by means of ctypes.

The library is libcatan.so, or what CATAN_LIBRARY names. Calls release the interpreter's lock while they wait.
"""

import ctypes
import os

_lib = ctypes.CDLL(os.environ.get("CATAN_LIBRARY", "libcatan.so.0.1"))


def _declare(name, result, *arguments):
    function = getattr(_lib, name)
    function.restype, function.argtypes = result, list(arguments)
    return function


_pointer, _text, _out = ctypes.c_void_p, ctypes.c_char_p, ctypes.POINTER(ctypes.c_void_p)
_version = _declare("catan_version", ctypes.c_uint32)
_message = _declare("catan_error_message", _text, _pointer)
_free_error = _declare("catan_error_free", None, _pointer)
_connect = _declare("catan_client_connect", _pointer, _pointer, _out)
_start = _declare("catan_client_start", ctypes.c_int, _pointer, _out)
_attach = _declare("catan_client_attach", _pointer, _pointer, _text, _out)
_adopt = _declare("catan_client_adopt_this_thread", ctypes.c_int, _pointer, _text, _out)
_served = _declare("catan_client_served", ctypes.c_int, _pointer)
_stop = _declare("catan_client_stop", None, _pointer)
_free = _declare("catan_client_free", None, _pointer)
_wait = _declare("catan_node_wait", ctypes.c_int, _pointer)
_begin = _declare("catan_node_begin", _pointer, _pointer)
_end = _declare("catan_node_end", None, _pointer)
_number = _declare("catan_run_number", ctypes.c_uint64, _pointer)
_threads = _declare("catan_run_threads", ctypes.c_int, _pointer)
_set_mode = _declare("catan_run_set_mode", None, _pointer, ctypes.c_uint32)
_skip_output = _declare("catan_run_skip_output", None, _pointer)

if _version() // 100 != 1:
    raise ImportError("libcatan.so is of version %d, this file is for 0.1" % _version())


class Error(Exception):
    """What Catan says was wrong, and what to do about it."""


def _checked(call, *arguments):
    error = ctypes.c_void_p()
    result = call(*arguments, ctypes.byref(error))
    if error.value is None:
        return result
    text = _message(error).decode("utf-8", "replace")
    _free_error(error)
    raise Error(text)


class Run:
    """One execution of a node; good until it ends."""

    def __init__(self, handle):
        self._handle = handle

    @property
    def number(self):
        return _number(self._handle)

    @property
    def threads(self):
        """On how many threads the run should work."""
        return _threads(self._handle)

    def set_mode(self, mode):
        _set_mode(self._handle, mode)

    def skip_output(self):
        _skip_output(self._handle)


class Client:
    """Nodes of the app whose server CATAN_SOCKET names. Close it when no thread is in runs() any more."""

    def __init__(self):
        self._handle = _checked(_connect, None)
        _checked(_start, self._handle)

    def runs(self, node):
        """The calling thread becomes the node's. Yields each run, which lasts until the next is asked for."""
        attached = _checked(_attach, self._handle, node.encode())
        while _wait(attached):
            run = Run(_begin(attached))
            try:
                yield run
            finally:
                _end(attached)

    def adopt_this_thread(self, node):
        _checked(_adopt, self._handle, node.encode())

    @property
    def served(self):
        return bool(_served(self._handle))

    def stop(self):
        """Ends all runs(); from any thread."""
        _stop(self._handle)

    def close(self):
        _free(self._handle)
        self._handle = None
