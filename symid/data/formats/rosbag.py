"""Bags of ROS: files of ROS 1, and of ROS 2 in SQLite."""

from __future__ import annotations

from pathlib import Path

from symid.data.formats.extra import required
from symid.data.formats.messages import table_of_messages
from symid.data.memory import require_room
from symid.data.table import Table, damaged
from symid.errors import LogError

_BYTES_OF_A_VALUE = 8


def open_rosbag(path: Path, memory: int | None = None) -> Table:
    """Table in a bag: each number in its messages is a signal, with the times of its topic.

    Messages of a bag without definitions are read with those that ROS 2 Humble has. LogError if it is damaged, or
    rosbags is not installed.
    """
    highlevel = required("rosbags.highlevel", path)
    typesys = required("rosbags.typesys", path)
    require_room(path.stat().st_size // _BYTES_OF_A_VALUE, memory)
    standard = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    try:
        with highlevel.AnyReader([path], default_typestore=standard) as bag:
            require_room(bag.message_count, memory)
            known = [one for one in bag.connections if one.msgtype in bag.typestore.fielddefs]
            return (
                table_of_messages(
                    (connection.topic, time, bag.deserialize(raw, connection.msgtype))
                    for connection, time, raw in bag.messages(connections=known)
                )
                if known
                else table_of_messages(())
            )
    except LogError:
        raise
    except Exception as error:  # a damaged file raises various exceptions
        raise damaged(path, "ROS bag", error) from error
