# SPDX-License-Identifier: MIT
"""Reads bags of ROS 2 (rosbag2 in SQLite, .db3) as tables.

The name of a column is a topic and the path of a number in its messages: "/imu/linear_acceleration.x",
"/joint_states/position[2]", or "/joint_states/position[elbow]", whose element is found in the message's array "name".
The path of a time is the stamp of a topic ("/imu/header.stamp"), or the topic for the times of receipt ("/imu").
"""
from __future__ import annotations

import contextlib
import os
import pathlib
import sqlite3
from typing import Any, Iterator, Mapping, NamedTuple, NoReturn, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from nlo import cdr
from nlo._arrays import Array
from nlo._library import Error
from nlo._tables import nearest

_STAMP = "header.stamp"
_LONGEST_STEP = 5.0  # largest step for interpolation, in median steps
_OTHERS = {  # first bytes of a file, its kind, and the remedy
    b"\x89MCAP0\r\n": "is an MCAP file: ros2 bag convert writes it as SQLite (storage_id: sqlite3)",
    b"#ROSBAG V": "is a bag of ROS 1: rosbags-convert makes a bag of ROS 2 of it",
    b"\x28\xB5\x2F\xFD": "is compressed: zstd -d, then take the .db3 file",
}


def read_bag(path: Union[str, "os.PathLike[str]"], columns: Optional[Sequence[str]] = None,
             time: Optional[str] = None, interpolate: Optional[Mapping[str, float]] = None) -> dict[str, Array]:
    """Reads numbers of a bag as columns of a table. Each message of the topic of the time is one row.

    columns      names, as above; None: all numbers of all topics whose types are known
    time         name of the time, as above; None: the time of the topic of the first column, or, without `columns`, the
                 time of the topic with the most messages. It becomes the first column, in seconds since the first message
    interpolate  columns of other topics to be interpolated between their messages, such as a reference sensor at its own
                 rate, each with the full turn of an angle in its unit (2 * pi, 360), or 0 if it is not an angle

    If a column of another topic is not interpolated, its newest value is in the row after the message, and the other
    rows have NaN. An interpolated column has NaN where messages are missing. If the time is a stamp, topics with stamps
    are placed by their stamps, the other topics by the time of receipt.
    """
    with contextlib.closing(_Bag(path)) as bag, bag.errors():
        return bag.table(columns, time, dict(interpolate or {}))


class _Topic(NamedTuple):
    key: int
    name: str
    type: str


class _Series(NamedTuple):
    """Messages of one topic."""

    time_ns: npt.NDArray[np.int64]
    values: dict[str, Array]  #: by the names of the columns


class _Bag:
    def __init__(self, path: Union[str, "os.PathLike[str]"]) -> None:
        self._path = os.fspath(path)
        file = pathlib.Path(path)
        with open(file, "rb") as opened:
            head = opened.read(100)
        for start, what in _OTHERS.items():
            if head.startswith(start):
                self._fail(what)
        page = int.from_bytes(head[16:18], "big")
        needed = (65536 if page == 1 else page) * int.from_bytes(head[28:32], "big")
        if file.stat().st_size < max(needed, 1):
            self._fail(f"has {file.stat().st_size} bytes and needs {max(needed, 100)}: it was not copied whole, or is "
                       "still written")
        self._types, self._topics = cdr.Types(), {}
        self._database = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)
        self._database.text_factory = lambda data: data.decode(errors="replace")
        try:
            with self.errors():
                self._read_topics()
        except Error:
            self.close()
            raise

    def close(self) -> None:
        self._database.close()

    @contextlib.contextmanager
    def errors(self) -> Iterator[None]:
        """Turns errors of SQLite into nlo.Error."""
        try:
            yield
        except sqlite3.Error as error:
            raise Error(f"{self._path}: {error}: the bag is damaged or was not copied whole; sqlite3 {self._path} "
                        ".recover saves what can be read") from error

    def _read_topics(self) -> None:
        tables = {name for name, in self._database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        if not {"topics", "messages"} <= tables:
            self._fail("is an SQLite file without the tables of a rosbag2: expected a .db3 of ros2 bag record")
        for key, name, of, form in self._database.execute("SELECT id, name, type, serialization_format FROM topics"):
            if form != "cdr":
                self._fail(f"{name} is serialised as \"{form}\": expected cdr; ros2 bag convert writes it")
            self._topics[name] = _Topic(key, name, of)
        if "message_definitions" in tables:
            for name, encoding, text in self._database.execute(
                    "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"):
                if encoding == "ros2msg":
                    self._types.define(name, text)

    def table(self, columns: Optional[Sequence[str]], time: Optional[str],
              interpolate: Mapping[str, float]) -> dict[str, Array]:
        columns = self._all_columns() if columns is None else columns
        places = {name: self._place_of(name) for name in columns}
        for name, (_, path) in places.items():
            if not path:
                self._fail(f"{name} is a topic: name a number of its messages, as {name}/data")
        for name in interpolate:
            if name not in places:
                self._fail(f"interpolate: no column \"{name}\"{nearest(name, places)}")
        if time is None:
            time = self._time_of(places[columns[0]][0]) if places else self._fail("no column is named")
        topic, path = self._place_of(time)
        rows_ns = self._series(topic, {}, path).time_ns
        if len(rows_ns) == 0:
            self._fail(f"{topic.name} has no messages")
        table = {time: 1e-9 * (rows_ns - rows_ns[0])}
        series = {}
        for other in self._topics.values():
            wanted = {name: own for name, (of, own) in places.items() if of == other}
            stamped = path == _STAMP and self._has_stamps(other)
            if wanted:
                series[other] = self._series(other, wanted, path if other == topic else _STAMP if stamped else "")
        for name, (of, _) in places.items():
            found = series[of]
            if of == topic:
                table[name] = found.values[name]
            elif name in interpolate:
                table[name] = _interpolated(rows_ns, *_sorted(found, name), interpolate[name])
            else:
                table[name] = _newest(rows_ns, *_sorted(found, name))
        return table

    def _all_columns(self) -> list[str]:
        """Returns all numbers of topics whose types are known; those of the topic with the most messages come first."""
        count = dict(self._database.execute("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id"))
        found: list[str] = []
        for topic in sorted(self._topics.values(), key=lambda each: -count.get(each.key, 0)):
            for _, data in self._messages(topic) if self._types.knows(topic.type) else ():
                with contextlib.suppress(Error):  # it contains an unknown type
                    message = cdr.decode(self._types, topic.type, data)
                    found += [f"{topic.name}/{path}" for path in cdr.numbers_of(self._types, topic.type, message)]
                break
        if not found:
            self._fail("no topic has numbers of a known type: record with ROS 2 Iron or newer, which stores the "
                       "definitions in the bag")
        return found

    def _place_of(self, name: str) -> tuple[_Topic, str]:
        """Returns the longest topic with which `name` begins, and the rest of `name`: the path in its messages."""
        topics = [topic for topic in self._topics if name == topic or name.startswith(topic + "/")]
        if not topics:
            self._fail(f"no topic of \"{name}\" among {', '.join(self._topics)}{nearest(name, self._topics)}")
        topic = max(topics, key=len)
        return self._topics[topic], name[len(topic) + 1:]

    def _time_of(self, topic: _Topic) -> str:
        return f"{topic.name}/{_STAMP}" if self._has_stamps(topic) else topic.name

    def _has_stamps(self, topic: _Topic) -> bool:
        return self._types.knows(topic.type) and any(
            field.name == "header" and field.type == "std_msgs/Header" for field in self._types.fields(topic.type))

    def _messages(self, topic: _Topic) -> Iterator[tuple[int, bytes]]:
        """Yields (time of receipt [ns], data) in the order of receipt."""
        for time_ns, data in self._database.execute(
                "SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY timestamp, id", (topic.key,)):
            if not isinstance(time_ns, int) or not isinstance(data, bytes):
                self._fail(f"a message of {topic.name} is not in its table as bytes with a time: the bag is damaged")
            yield time_ns, data

    def _series(self, topic: _Topic, paths: Mapping[str, str], time_path: str) -> _Series:
        """Returns the numbers `paths` of all messages, with their times: the number `time_path`, or the time of receipt."""
        if not self._types.knows(topic.type):
            self._fail(f"{topic.name} has messages of type {topic.type}, whose definition is neither in the bag nor "
                       "known: record with ROS 2 Iron or newer, which stores it, or republish as a type of std_msgs")
        steps = {}
        for name, path in [*paths.items(), *([("", time_path)] if time_path else [])]:
            try:
                steps[name] = cdr.steps_of(self._types, topic.type, path)
            except Error as error:
                self._fail(f"{topic.name}/{path}: {error}")
        times, values = [], {name: [] for name in paths}  # type: tuple[list[Any], dict[str, list[Any]]]
        for received_ns, data in self._messages(topic):
            try:
                message = cdr.decode(self._types, topic.type, data)
            except Error as error:
                self._fail(f"message {len(times) + 1} of {topic.name} {error}: the bag is damaged, or its messages are "
                           f"not of type {topic.type}")
            times.append(cdr.value(message, steps[""]) if time_path else received_ns)
            for name, column in values.items():
                column.append(cdr.value(message, steps[name]))
        return _Series(np.array(times, dtype=np.int64), {name: np.array(column, dtype=float)
                                                         for name, column in values.items()})

    def _fail(self, what: str) -> NoReturn:
        raise Error(f"{self._path}: {what}")


def _sorted(series: _Series, name: str) -> tuple[npt.NDArray[np.int64], Array]:
    order = np.argsort(series.time_ns, kind="stable")
    return series.time_ns[order], series.values[name][order]


def _newest(rows_ns: npt.NDArray[np.int64], time_ns: npt.NDArray[np.int64], values: Array) -> Array:
    """Puts each newest value into the first row at or after it; rows without a new value get NaN."""
    count = np.maximum.accumulate(np.searchsorted(time_ns, rows_ns, side="right"))
    is_new = np.diff(count, prepend=0) > 0
    result = np.full(len(rows_ns), np.nan)
    result[is_new] = values[count[is_new] - 1]
    return result


def _interpolated(rows_ns: npt.NDArray[np.int64], time_ns: npt.NDArray[np.int64], values: Array, turn: float) -> Array:
    """Interpolates linearly between messages; an angle with a full `turn` goes the shorter way. NaN before the first
    message, after the last, and where messages are missing."""
    result = np.full(len(rows_ns), np.nan)
    longest = _LONGEST_STEP * float(np.median(np.diff(time_ns))) if len(time_ns) > 1 else 0.0
    after = np.searchsorted(time_ns, rows_ns)
    for k, (row, i) in enumerate(zip(rows_ns, after)):
        if i == len(time_ns):
            continue
        if time_ns[i] == row:
            result[k] = values[i]
        elif i > 0 and time_ns[i] - time_ns[i - 1] <= longest:
            way = values[i] - values[i - 1]
            if turn > 0:
                way -= turn * np.round(way / turn)
            result[k] = values[i - 1] + (row - time_ns[i - 1]) / (time_ns[i] - time_ns[i - 1]) * way
    return result
