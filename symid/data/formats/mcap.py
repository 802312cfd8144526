"""MCAP files: messages of ROS 2 and of JSON, with their definitions in the file."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from symid.data.formats.extra import required
from symid.data.formats.messages import table_of_messages
from symid.data.memory import require_room
from symid.data.table import Table, damaged
from symid.errors import LogError

_BYTES_OF_A_VALUE = 8


def open_mcap(path: Path, memory: int | None = None) -> Table:
    """Table in an MCAP file: each number in its messages is a signal, with the times of its topic.

    LogError if it is damaged, holds messages of other encodings only, or mcap is not installed.
    """
    reader = required("mcap.reader", path)
    ros2 = required("mcap_ros2.decoder", path)
    require_room(path.stat().st_size // _BYTES_OF_A_VALUE, memory)
    try:
        with path.open("rb") as stream:
            decoders = [ros2.DecoderFactory(), _Json()]
            opened = reader.make_reader(stream, decoder_factories=decoders)
            summary = opened.get_summary()
            if summary and summary.statistics:
                require_room(summary.statistics.message_count, memory)
            read = _readable(summary) if summary else None
            if read == []:
                other = ", ".join(sorted({one.message_encoding for one in summary.channels.values()}))
                raise LogError(f"{path}: its messages are in {other or 'no encoding'}: record ROS 2 or JSON")
            return table_of_messages(
                (channel.topic, message.log_time, decoded)
                for _, channel, message, decoded in opened.iter_decoded_messages(topics=read)
            )
    except LogError:
        raise
    except Exception as error:  # a damaged file raises various exceptions
        raise damaged(path, "MCAP", error) from error


def _readable(summary: Any) -> list[str]:
    """Topics whose messages are decoded."""
    found = []
    for channel in summary.channels.values():
        schema = summary.schemas.get(channel.schema_id)
        ros2 = channel.message_encoding == "cdr" and schema is not None and schema.encoding == "ros2msg"
        if ros2 or channel.message_encoding == "json":
            found.append(channel.topic)
    return found


class _Json:
    """Decoder of JSON messages, as mcap asks for one."""

    def decoder_for(self, message_encoding: str, schema: object) -> Callable[[bytes], object] | None:
        """Decoder of an encoding, or None."""
        return json.loads if message_encoding == "json" else None
