"""What ROS would have heard while an arm drew goes in; a bag of ROS 1 or ROS 2 comes out."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from limner import storage
from limner.errors import BadInput, MissingExtra
from limner.targets.recording import LATCHED, TOPICS, Message, Recording, messages

FORMATS = (".bag", ".mcap", ".db3")
"""ROS 1, ROS 2 as MCAP, ROS 2 as SQLite."""

_METADATA = "metadata.yaml"


def check(path: str | Path) -> str:
    """The path's suffix, if a bag can be written there.

    Raises:
        BadInput: it cannot be that, or something else is in its place.
        MissingExtra: rosbags is not installed.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise BadInput(f"{path}: a bag cannot be '{suffix}'; choose {', '.join(FORMATS)}")
    if path.exists() and not (path.is_file() if suffix == ".bag" else _is_ros2_bag(path)):
        kind = "a file" if suffix == ".bag" else f"a folder with {_METADATA}"
        raise BadInput(f"{path}: something else has this name, a bag of this kind is {kind}; choose another name")
    if importlib.util.find_spec("rosbags") is None:
        raise MissingExtra("writing a bag", "ros")
    return suffix


def _is_ros2_bag(path: Path) -> bool:
    """Whether a folder holds a bag and nothing else, so that it may be replaced."""
    if not path.is_dir():
        return False
    names = {inner.name for inner in path.iterdir()}
    return _METADATA in names and all(Path(name).suffix in FORMATS for name in names - {_METADATA})


def save(recording: Recording, path: str | Path) -> None:
    """Write a bag, whole or not at all: one file for ROS 1, for ROS 2 a folder as ``ros2 bag play`` takes it.

    Raises:
        BadInput: it cannot be written there, or the motion is none that a controller takes.
        MissingExtra: rosbags is not installed.
    """
    suffix = check(path)
    with storage.whole(path) as beside:
        if suffix == ".bag":
            _write_ros1(beside, messages(recording))
        else:
            # The file in the folder is called after the folder, which shall not end in a suffix twice.
            plain = beside.with_suffix("")
            _write_ros2(plain, suffix, messages(recording))
            plain.rename(beside)


def _write_ros1(path: Path, said: Iterable[Message]) -> None:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores

    store = _types(Stores.ROS1_NOETIC)
    with Writer(path) as writer:
        topics = {
            topic: writer.add_connection(
                topic, kind, typestore=store, callerid="/limner", latching=int(topic in LATCHED)
            )
            for topic, kind in TOPICS.items()
        }
        for time_ns, topic, fields in said:
            data = store.serialize_ros1(_filled(store, TOPICS[topic], fields), TOPICS[topic])
            writer.write(topics[topic], time_ns, data)


def _write_ros2(path: Path, suffix: str, said: Iterable[Message]) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores

    store = _types(Stores.ROS2_HUMBLE)
    plugin = StoragePlugin.MCAP if suffix == ".mcap" else StoragePlugin.SQLITE3
    # Version 8 of the format is read by Humble and by all that came after it.
    with Writer(path, version=8, storage_plugin=plugin) as writer:
        topics = {
            topic: writer.add_connection(
                topic, kind, typestore=store, offered_qos_profiles=[_quality(topic in LATCHED)]
            )
            for topic, kind in TOPICS.items()
        }
        for time_ns, topic, fields in said:
            data = store.serialize_cdr(_filled(store, TOPICS[topic], fields), TOPICS[topic])
            writer.write(topics[topic], time_ns, data)


def _types(release: Any) -> Any:
    """All types of messages of a release of ROS, and the one for frames, which the library lacks."""
    from rosbags.typesys import get_types_from_msg, get_typestore

    store, name = get_typestore(release), TOPICS["/tf"]
    if name not in store.fielddefs:
        store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms\n", name))
    return store


def _quality(latched: bool) -> Any:
    """Reliable, and kept for who comes later where a topic is latched."""
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    never = QosTime(0, 0)
    durability = QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE
    history, live = QosHistory.KEEP_LAST, QosLiveliness.AUTOMATIC
    return Qos(history, 10, QosReliability.RELIABLE, durability, never, never, live, never, False)


def _filled(store: Any, kind: str, fields: dict[str, Any]) -> Any:
    """A message of a type, zero wherever nothing is given: what the two ROS name differently is left out."""
    definition = store.fielddefs[kind][1]
    values = {name: _value(store, description, fields.get(name)) for name, description in definition}
    return store.types[kind](**values)


def _value(store: Any, description: Any, given: Any) -> Any:
    from rosbags.interfaces import Nodetype

    node, inner = description
    if node == Nodetype.BASE:
        zero: Callable[[], Any] = {"string": str, "bool": bool}.get(inner[0], int)
        return zero() if given is None else given
    if node == Nodetype.NAME:
        return _filled(store, inner, given or {})
    items = given or []
    if inner[0][0] == Nodetype.BASE and inner[0][1][0] != "string":
        return np.array(items, dtype=inner[0][1][0])
    return [_value(store, inner[0], item) for item in items]
