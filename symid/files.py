"""Reading of regular files, not of pipes or devices, and writing of whole files.

A writer fills a temporary file beside the target and then renames it: after a full disk, a crash or Ctrl-C the former
file is still there.
"""

import contextlib
import errno
import json
import math
import os
import re
import shutil
import stat
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from symid.errors import SettingError
from symid.text import listed

_LARGEST_JSON: Final = 64_000_000
"""Size of the largest JSON file of settings, bytes; a larger file is something else."""

_UNSEEN: Final = re.compile("[\x7f-\x9f\u2028\u2029\ud800-\udfff]")
"""Characters that JSON does not escape and terminals do not show."""
_KINDS: Final = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def irregular(path: str | os.PathLike[str]) -> str | None:
    """Kind of a file that is not regular, whose reading might never end; None for a regular file.

    >>> irregular("/"), irregular(__file__)
    ('a folder', None)
    """
    mode = os.stat(path).st_mode
    return next((name for is_kind, name in _KINDS if is_kind(mode)), None)


def require_regular(path: str | os.PathLike[str], error: type[Exception] = SettingError) -> None:
    """Raise an error of the given type unless the path leads to a regular file."""
    try:
        kind = irregular(path)
    except FileNotFoundError as failure:
        raise error(f"{path}: there is no such file: check the path") from failure
    except (OSError, ValueError) as failure:  # ValueError: a null byte in the path
        cause = getattr(failure, "strerror", None) or str(failure)
        raise error(f"{path}: cannot be read ({cause}): check the path") from failure
    if kind:
        raise error(f"{path}: is {kind}: give a regular file")


def written_path(what: str, file: str | os.PathLike[str], *suffixes: str) -> Path:
    """Path of a file to write; SettingError unless it ends with one of the suffixes, in any case.

    >>> written_path("log", "run.csv", ".csv", ".parquet").name
    'run.csv'
    """
    path = Path(file)
    if path.suffix.lower() not in suffixes:
        raise SettingError(
            f"{what} {str(path)!r} is of an unknown kind: end its name with {listed(suffixes, 'or')}"
        )
    return path


def read_json(file: str | os.PathLike[str]) -> Any:
    """Content of a JSON file of settings."""
    path = Path(file)
    require_regular(path)
    try:
        if path.stat().st_size > _LARGEST_JSON:
            raise SettingError(f"is longer than {_LARGEST_JSON // 10**6} MB: give a file of settings")
        text = path.read_text(encoding="utf-8-sig")
        return json.loads(text, parse_int=_integer, object_pairs_hook=_named_once)
    except SettingError as error:
        raise SettingError(f"{path}: {error}") from None
    except RecursionError as error:
        raise SettingError(f"{path}: is nested too deep: correct it") from error
    except ValueError as error:
        raise SettingError(f"{path}: is not JSON ({error}): correct it") from error
    except OSError as error:
        raise SettingError(f"{path}: cannot be read ({error.strerror}): check the file") from error


def _named_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON, whose last value of a name would count if that stood twice."""
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = sorted(name for name, times in Counter(name for name, _ in pairs).items() if times > 1)
        raise SettingError(f"holds {', '.join(twice)} more than once: keep one value of each")
    return found


def as_json(record: object, *, ascii_only: bool = False) -> str:
    r"""JSON text of a record; numbers that are not finite become null, and control characters are escaped.

    >>> print(as_json({"a\udce9": float("nan")}), end="")
    {
      "a\udce9": null
    }
    """
    text = json.dumps(_finite(record), indent=2, ensure_ascii=ascii_only, allow_nan=False) + "\n"
    return _UNSEEN.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def is_finite_number(value: object) -> bool:
    """Whether a JSON value is a finite number; true and false are not.

    >>> [is_finite_number(value) for value in (1, 2.5, True, "1", float("nan"), None)]
    [True, True, False, False, False, False]
    """
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer that no float holds
        return False


def shortened(value: object) -> str:
    """Value of a JSON file, shortened to 60 characters for a message.

    >>> shortened("12"), shortened([0] * 100)[-9:]
    ("'12'", ' 0, 0,...')
    """
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _integer(digits: str) -> int | float:
    """An integer; infinity if it exceeds the range of floats, so that checks for finite numbers refuse it."""
    return int(digits) if len(digits) <= 300 else float(digits)


@contextlib.contextmanager
def replacing(file: str | os.PathLike[str]) -> Iterator[Path]:
    """Path of a temporary file, which replaces the target once it is filled; after a failure the target is unchanged.

    A link stays a link to the file that is replaced. A pipe or a device, such as /dev/stdout, is written to.

    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with replacing(Path(folder) / "a.txt") as path:
    ...         _ = path.write_text("whole")
    ...     [(file.name, file.read_text()) for file in Path(folder).iterdir()]
    [('a.txt', 'whole')]
    """
    target = Path(os.path.realpath(file))
    try:
        special = target.exists() and not target.is_file()
        if special and target.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        with (
            tempfile.TemporaryDirectory() if special else contextlib.nullcontext(str(target.parent)) as folder
        ):
            unfinished = _created(Path(folder), target)
            try:
                yield unfinished
                _sync(unfinished)
                if special:
                    _copy_into_pipe(unfinished, target)
                else:
                    os.replace(unfinished, target)
            finally:
                unfinished.unlink(missing_ok=True)
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(file)) from error


def write_whole(file: str | os.PathLike[str], text: str) -> None:
    """Write a text file in UTF-8 as a whole or not at all; OSError if that is not possible."""
    with replacing(file) as unfinished:
        unfinished.write_text(text, encoding="utf-8", errors="backslashreplace", newline="")


def free_name(file: Path, suffix: str) -> Path:
    """The first of FILE.SUFFIX, FILE.SUFFIX2, FILE.SUFFIX3, ... that is not there.

    >>> free_name(Path("no_such_file.csv"), ".before").name
    'no_such_file.csv.before'
    """
    place = file.with_name(file.name + suffix)
    count = 1
    while os.path.lexists(place):
        count += 1
        place = file.with_name(f"{file.name}{suffix}{count}")
    return place


def _created(folder: Path, target: Path) -> Path:
    """An empty file with the rights that the target has, or that a new file gets; its suffix is that of the target."""
    for attempt in range(1000):
        path = folder / f".symid-{os.getpid()}-{attempt}{target.suffix}"
        try:
            os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        except FileExistsError:
            continue
        if target.is_file():
            shutil.copymode(target, path)
        return path
    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(folder))


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _copy_into_pipe(source: Path, target: Path) -> None:
    """Copy a file into a pipe or a device; a pipe that nobody reads is an error, not a wait."""
    handle = os.open(target, os.O_WRONLY | getattr(os, "O_NONBLOCK", 0))
    os.set_blocking(handle, True)
    with source.open("rb") as read, os.fdopen(handle, "wb") as written:
        shutil.copyfileobj(read, written)
