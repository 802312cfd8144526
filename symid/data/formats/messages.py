"""MCAP files and bags of ROS: each number in their messages is a sample of a signal, named by topic and fields."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from symid.data.formats.channels import Channel, short_names, table_of_channels
from symid.data.formats.extra import required
from symid.data.table import Table, parsing, require_memory
from symid.errors import LogError

_BYTES_OF_A_VALUE: Final = 8
_DEEPEST, _LONGEST_ARRAY = 8, 64  # levels of nested fields; an array beyond it is data such as an image
_STAMPS: Final = ("stamp", "timestamp")
_SECONDS, _NANOSECONDS = ("sec", "secs"), ("nanosec", "nsec", "nsecs")


def open_mcap(path: Path, memory: int | None = None) -> Table:
    """Table in an MCAP file: each number in its messages is a signal, with the times of its topic.

    The definitions of its messages, of ROS 2 or JSON, are in the file. LogError if it is damaged, holds messages of
    other encodings only, or mcap is not installed.
    """
    reader = required("mcap.reader", path)
    ros2 = required("mcap_ros2.decoder", path)
    require_memory(path.stat().st_size // _BYTES_OF_A_VALUE, memory)
    with parsing(path, "MCAP"), path.open("rb") as stream:
        opened = reader.make_reader(stream, decoder_factories=[ros2.DecoderFactory(), _Json()])
        summary = opened.get_summary()
        if summary and summary.statistics:
            require_memory(summary.statistics.message_count, memory)
        read = _readable(summary) if summary else None
        if read == []:
            encodings = ", ".join(sorted({one.message_encoding for one in summary.channels.values()}))
            raise LogError(f"{path}: its messages are in {encodings or 'no encoding'}: record ROS 2 or JSON")
        return table_of_messages(
            (channel.topic, message.log_time, decoded)
            for _, channel, message, decoded in opened.iter_decoded_messages(topics=read)
        )


def _readable(summary: Any) -> list[str]:
    """Topics whose messages are decoded."""
    topics = []
    for channel in summary.channels.values():
        schema = summary.schemas.get(channel.schema_id)
        ros2 = channel.message_encoding == "cdr" and schema is not None and schema.encoding == "ros2msg"
        if ros2 or channel.message_encoding == "json":
            topics.append(channel.topic)
    return topics


class _Json:
    """Decoder of JSON messages, as mcap asks for one."""

    def decoder_for(self, message_encoding: str, schema: object) -> Callable[[bytes], object] | None:
        """Decoder of an encoding, or None."""
        return json.loads if message_encoding == "json" else None


def open_rosbag(path: Path, memory: int | None = None) -> Table:
    """Table in a bag of ROS 1, or of ROS 2 in SQLite: its signals are as those of `open_mcap`.

    Messages of a bag without definitions are read with those that ROS 2 Humble has. LogError if it is damaged, or
    rosbags is not installed.
    """
    highlevel = required("rosbags.highlevel", path)
    typesys = required("rosbags.typesys", path)
    require_memory(path.stat().st_size // _BYTES_OF_A_VALUE, memory)
    standard = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    with parsing(path, "ROS bag"), highlevel.AnyReader([path], default_typestore=standard) as bag:
        require_memory(bag.message_count, memory)
        known = [one for one in bag.connections if one.msgtype in bag.typestore.fielddefs]
        return table_of_messages(  # without connections, all messages would be read
            (connection.topic, time, bag.deserialize(raw, connection.msgtype))
            for connection, time, raw in (bag.messages(connections=known) if known else ())
        )


def table_of_messages(messages: Iterable[tuple[str, int, object]]) -> Table:
    """Messages as a table: each topic has its clock, which begins with the first message of all.

    Each message comes with its topic and its time of recording in ns. It is timed by its header where it has a stamp,
    otherwise by its recording. Elements of arrays are named by the names that stand beside them, as in ``JointState``,
    or by their numbers.

    >>> joints = {"name": ["x", "y"], "position": [0.1, 0.2]}
    >>> table_of_messages([("/joints", 5, joints), ("/joints", 7, joints)]).headers
    ('joints.x.position', 'joints.y.position', 't')
    """
    times: dict[str, list[int]] = {}
    samples: dict[tuple[str, ...], tuple[list[int], list[float]]] = {}
    for topic, recorded, message in messages:
        time = times.setdefault(topic.lstrip("/"), [])
        for path, value in _numbers(message, ()):
            rows, values = samples.setdefault((topic.lstrip("/"), *path), ([], []))
            rows.append(len(time))
            values.append(value)
        time.append(_stamp_of(message) or recorded)
    first = min((min(time) for time in times.values()), default=0)
    seconds = {
        topic: np.asarray((np.array(time, np.int64) - first) / 1e9, np.float64)
        for topic, time in times.items()
    }
    channels = []
    # Signals are named by the last field where it is there once; of ``/force`` with ``data``, by the topic.
    topics = {path[0] for path in samples if path[1:] == ("data",)}
    names = short_names([path[:1] if path[0] in topics else path for path in samples])
    for name, (path, (rows, values)) in zip(names, samples.items(), strict=True):
        clock = seconds[path[0]]
        when = clock if len(rows) == clock.size else clock[rows]
        channels.append(Channel(name, "", when, np.array(values)))
    return table_of_channels(channels)


def _fields_of(message: object) -> Mapping[str, Any] | None:
    """Fields of a message by name; None for anything else."""
    if isinstance(message, Mapping):
        return message
    names = getattr(message, "__dataclass_fields__", None) or getattr(message, "__slots__", None)
    return {name: getattr(message, name) for name in names if not name.startswith("_")} if names else None


def _stamp_of(message: object) -> int | None:
    """Time in the header of a message, ns; None where there is none or it is 0."""
    fields = _fields_of(message) or {}
    header = _fields_of(fields.get("header")) or fields
    stamp = next((found for name in _STAMPS if (found := _fields_of(header.get(name)))), None)
    if stamp is None:
        return None
    whole, part = (next((stamp[n] for n in names if n in stamp), None) for names in (_SECONDS, _NANOSECONDS))
    if not isinstance(whole, int) or not isinstance(part, int):
        return None
    return 1_000_000_000 * whole + part or None


def _numbers(value: object, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], float]]:
    """Numbers in a message with the names that lead to them; those of headers and long arrays are left out."""
    if isinstance(value, (bool, int, float, np.number, np.bool_)):
        yield path, float(value)
        return
    if len(path) > _DEEPEST or isinstance(value, (str, bytes)):
        return
    fields = _fields_of(value)
    if fields is not None:
        names = fields.get("name")
        for field, inner in fields.items():
            if field == "header" or field in _STAMPS:
                continue
            is_array = isinstance(inner, (list, tuple, np.ndarray))
            if isinstance(names, (list, tuple)) and field != "name" and is_array and len(inner) == len(names):
                for name, values in zip(names, inner, strict=True):
                    yield from _numbers(values, (*path, str(name), field))
            else:
                yield from _numbers(inner, (*path, field))
    elif isinstance(value, (list, tuple, np.ndarray)) and len(value) <= _LONGEST_ARRAY:
        for i, inner in enumerate(value):
            yield from _numbers(inner, (*path[:-1], f"{path[-1]}[{i}]") if path else (f"[{i}]",))


READERS = {".mcap": open_mcap, ".db3": open_rosbag, ".bag": open_rosbag}
