"""Messages of MCAP files and ROS bags as columns."""

from pathlib import Path

import numpy as np
import pytest
from log_formats import EXPECTED, PERIOD, STAMPS, F, Q, mcap_of_ros2, rosbag1
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer as FolderWriter
from rosbags.typesys import Stores, get_typestore

from symid.data import open_table, read_log
from symid.errors import LogError


def test_joints_are_named_by_their_message(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    joints, header, moment = (
        store.types[f"{package}/msg/{name}"]
        for package, name in (
            ("sensor_msgs", "JointState"),
            ("std_msgs", "Header"),
            ("builtin_interfaces", "Time"),
        )
    )
    with FolderWriter(tmp_path / "run", version=8, storage_plugin=StoragePlugin.MCAP) as bag:
        topic = bag.add_connection("/joint_states", joints.__msgtype__, typestore=store)
        for stamp, q, f in zip(STAMPS, Q, F, strict=True):
            stamped = header(moment(stamp // 10**9, stamp % 10**9), "")
            message = joints(stamped, ["a", "b"], np.array([q, 0.0]), np.array([]), np.array([f, 1.0]))
            bag.write(topic, stamp + 700_000, store.serialize_cdr(message, joints.__msgtype__))
    columns = {"q": "joint_states.a.position", "F": "joint_states.a.effort"}
    log = read_log(tmp_path / "run" / "run.mcap", expected=EXPECTED, columns=columns)
    assert log.sampling_period == PERIOD
    np.testing.assert_array_equal(log["q"], Q)
    np.testing.assert_array_equal(log["F"], F)


def test_fields_of_messages_are_columns(tmp_path: Path) -> None:
    rosbag1(tmp_path / "a.bag")
    mcap_of_ros2(tmp_path / "a.mcap")
    for name, columns in (("a.bag", {"q": "x", "F": "y"}), ("a.mcap", {"F": "force"})):
        log = read_log(tmp_path / name, expected=EXPECTED, columns=columns)
        assert log.sampling_period == PERIOD
        np.testing.assert_array_equal(log["q"], Q)
        np.testing.assert_array_equal(log["F"], F)


def test_messages_in_another_encoding_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        channel = writer.register_channel("/a", "protobuf", writer.register_schema("a", "protobuf", b""))
        writer.add_message(channel, 0, b"", 0)
        writer.finish()
    with pytest.raises(LogError, match=r"p\.mcap: its messages are in protobuf: record ROS 2 or JSON"):
        open_table(path)
