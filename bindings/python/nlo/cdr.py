# SPDX-License-Identifier: MIT
"""Decodes messages of ROS 2 (CDR, XCDR1) by the definitions of their types.

In CDR the fields of a message follow each other; the position of a number is a multiple of its size.
"""
from __future__ import annotations

import re
import struct
from typing import Any, Iterator, NamedTuple, Optional, Union

import numpy as np

from nlo._library import Error
from nlo._tables import nearest

_DEEPEST = 32  # messages within messages: a definition may contain itself
_LONGEST = 32  # elements of an array that numbers_of() lists
_FORMATS = {"bool": "B", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i",
            "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}
_TEXT = ("string", "wstring")
_TIMES = ("builtin_interfaces/Time", "builtin_interfaces/Duration")


class Field(NamedTuple):
    name: str
    type: str              #: "float64", "string", "geometry_msgs/Vector3"
    is_array: bool = False
    length: int = 0        #: of an array; 0: the message has its length


class Types:
    """The types of messages by their names, such as "sensor_msgs/Imu". Common types are known from the start."""

    def __init__(self) -> None:
        self._fields: dict[str, list[Field]] = {}
        self.define("", _COMMON)

    def define(self, name: str, text: str) -> None:
        """Adds type `name` from the text of its .msg file. A line "MSG: other/Type" begins another type that it uses."""
        name = plain(name)
        if name:
            self._fields[name] = []
        for line in text.splitlines():
            if line.startswith("MSG:"):
                name = plain(line[4:].strip())
                self._fields[name] = []
            elif name and not line.startswith("===="):
                self._fields[name] += _fields_of(line, name)

    def knows(self, name: str) -> bool:
        return plain(name) in self._fields

    def fields(self, name: str) -> list[Field]:
        if not self.knows(name):
            raise Error(f"has a {name}, whose definition is not in the bag")
        return self._fields[plain(name)]


def plain(name: str) -> str:
    """Shortens "sensor_msgs/msg/Imu" to "sensor_msgs/Imu"."""
    return name.replace("/msg/", "/")


def _fields_of(line: str, name: str) -> Iterator[Field]:
    """Yields the field of a line of a definition, or nothing if the line is empty, a comment or a constant."""
    words = line.split("#")[0].split()
    if not words or re.match(r"\w+\s+\w+\s*=", line.strip()):
        return
    found = re.fullmatch(r"([\w/]+)(?:<=\d+)?(\[(?:<=\d+|([1-9]\d*))?\])?", words[0])
    if found is None or len(words) < 2:
        raise Error(f"the definition of {name} has a line that is not a field: \"{line.strip()}\"")
    of = "std_msgs/Header" if found[1] == "Header" else plain(found[1])
    if of not in _FORMATS and of not in _TEXT and "/" not in of:
        of = f"{name.split('/')[0]}/{of}"
    yield Field(words[1], of, found[2] is not None, int(found[3] or 0))


def decode(types: Types, name: str, data: bytes) -> dict[str, Any]:
    """Decodes a message into a dict of its fields: numbers, texts, dicts, and arrays or lists of these."""
    return _Decoder(types, data).message(name, 0)


class _Decoder:
    def __init__(self, types: Types, data: bytes) -> None:
        if len(data) < 4:
            raise Error("is too short for a message")
        if data.startswith(b"\x28\xB5\x2F\xFD"):
            raise Error("is compressed: ros2 bag convert writes it without compression")
        if data[0] != 0 or data[1] not in (0, 1):
            raise Error("is not plain CDR")
        self._types, self._data, self._at = types, data[4:], 0
        self._order = "<" if data[1] == 1 else ">"

    def message(self, name: str, depth: int) -> dict[str, Any]:
        if depth > _DEEPEST:
            raise Error(f"has messages within messages, {depth} deep")
        fields = self._types.fields(name)
        if not fields:
            self._take(1, 1)  # an empty message has one byte
        return {field.name: self._field(field, depth) for field in fields}

    def _field(self, field: Field, depth: int) -> Any:
        if not field.is_array:
            return self._one(field.type, depth)
        length = field.length or self._number("I")
        if form := _FORMATS.get(field.type):
            size = struct.calcsize(form)
            return np.frombuffer(self._take(size, length) if length else b"", dtype=self._order + form)
        return [self._one(field.type, depth) for _ in range(length)]

    def _one(self, of: str, depth: int) -> Any:
        if form := _FORMATS.get(of):
            return self._number(form)
        if of not in _TEXT:
            return self.message(of, depth + 1)
        length = self._number("I")
        data = self._take(4 if of == "wstring" else 1, length) if length else b""
        return data.split(b"\0")[0].decode(errors="replace") if of == "string" else ""

    def _number(self, form: str) -> Any:
        return struct.unpack(self._order + form, self._take(struct.calcsize(form), 1))[0]

    def _take(self, size: int, count: int) -> bytes:
        begin = -(-self._at // size) * size
        end = begin + size * count
        if end > len(self._data):
            raise Error(f"ends after {len(self._data) + 4} bytes, within a field")
        self._at = end
        return self._data[begin:end]


class Step(NamedTuple):
    field: str
    element: Union[None, int, str] = None  #: number from 0, or a name that the message's array "name" has


def steps_of(types: Types, name: str, path: str) -> list[Step]:
    """Returns the steps to the number `path` of a type: "linear_acceleration.x", "position[2]", "position[elbow]"."""
    steps: list[Step] = []
    of: Optional[str] = name
    for part in re.findall(r"[^.\[]+(?:\[[^\]]*\])?", path):
        if of is None or of in _FORMATS:
            raise Error(f"{steps[-1].field} is a {of}: it has no field {part}")
        found = re.fullmatch(r"([^\[]+)(?:\[(.*)\])?", part)
        assert found is not None
        fields = {field.name: field for field in types.fields(of)}
        if found[1] not in fields:
            raise Error(f"{plain(of)} has no \"{found[1]}\", it has {', '.join(fields)}{nearest(found[1], fields)}")
        field, element = fields[found[1]], found[2]
        if field.is_array and element is None:
            raise Error(f"{path} is an array: write {field.name}[0], or {field.name}[NAME] where the message has names")
        if not field.is_array and element is not None:
            raise Error(f"{field.name} is not an array: write {field.name} without [...]")
        if element is not None and not element.isdigit() and "name" not in fields:
            raise Error(f"{field.name}[{element}]: {plain(of)} has no array \"name\": write a number, from 0")
        steps.append(Step(field.name, int(element) if element is not None and element.isdigit() else element))
        of = field.type
    if of in _TEXT:
        raise Error(f"{path} is text: expected a number")
    if of not in _FORMATS and of not in _TIMES:
        raise Error(f"{path} is a {of}: name one of its fields, "
                    f"{', '.join(field.name for field in types.fields(str(of)))}")
    return steps


def value(message: Any, steps: list[Step]) -> Any:
    """Returns the number at the end of the steps: whole nanoseconds for a time, NaN if the element does not exist."""
    for step in steps:
        names, message = message.get("name"), message[step.field]
        if step.element is None:
            continue
        place = step.element
        if isinstance(place, str):
            place = list(names).index(place) if place in names else len(message)
        if place >= len(message):
            return float("nan")
        message = message[place]
    return nanoseconds(message) if isinstance(message, dict) else message


def nanoseconds(time: dict[str, int]) -> int:
    return 1_000_000_000 * time["sec"] + time["nanosec"]


def numbers_of(types: Types, name: str, message: dict[str, Any], above: str = "") -> Iterator[str]:
    """Yields the paths of all numbers in a message, without headers, times, covariances and long arrays."""
    for field in types.fields(name):
        found, path = message[field.name], above + field.name
        if field.type == "std_msgs/Header" or field.type in _TIMES or field.name.endswith("covariance"):
            continue
        if field.type in _FORMATS and not field.is_array:
            yield path
        elif field.type in _FORMATS and len(found) <= _LONGEST:
            yield from (f"{path}[{i}]" for i in range(len(found)))
        elif field.type not in _FORMATS and field.type not in _TEXT and not field.is_array:
            yield from numbers_of(types, field.type, found, path + ".")


# The most common messages as ROS 2 defines them (common_interfaces), because bags before Iron contain no definitions.
_COMMON = """\
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
MSG: std_msgs/Bool
bool data
MSG: std_msgs/Int8
int8 data
MSG: std_msgs/UInt8
uint8 data
MSG: std_msgs/Int16
int16 data
MSG: std_msgs/UInt16
uint16 data
MSG: std_msgs/Int32
int32 data
MSG: std_msgs/UInt32
uint32 data
MSG: std_msgs/Int64
int64 data
MSG: std_msgs/UInt64
uint64 data
MSG: std_msgs/Float32
float32 data
MSG: std_msgs/Float64
float64 data
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
MSG: std_msgs/MultiArrayLayout
MultiArrayDimension[] dim
uint32 data_offset
MSG: std_msgs/Float32MultiArray
MultiArrayLayout layout
float32[] data
MSG: std_msgs/Float64MultiArray
MultiArrayLayout layout
float64[] data
MSG: std_msgs/Int32MultiArray
MultiArrayLayout layout
int32[] data
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
MSG: geometry_msgs/Vector3Stamped
std_msgs/Header header
Vector3 vector
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
MSG: geometry_msgs/PointStamped
std_msgs/Header header
Point point
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
MSG: geometry_msgs/QuaternionStamped
std_msgs/Header header
Quaternion quaternion
MSG: geometry_msgs/Pose
Point position
Quaternion orientation
MSG: geometry_msgs/PoseStamped
std_msgs/Header header
Pose pose
MSG: geometry_msgs/PoseWithCovariance
Pose pose
float64[36] covariance
MSG: geometry_msgs/PoseWithCovarianceStamped
std_msgs/Header header
PoseWithCovariance pose
MSG: geometry_msgs/Transform
Vector3 translation
Quaternion rotation
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
Transform transform
MSG: geometry_msgs/Twist
Vector3 linear
Vector3 angular
MSG: geometry_msgs/TwistStamped
std_msgs/Header header
Twist twist
MSG: geometry_msgs/TwistWithCovariance
Twist twist
float64[36] covariance
MSG: geometry_msgs/TwistWithCovarianceStamped
std_msgs/Header header
TwistWithCovariance twist
MSG: geometry_msgs/Accel
Vector3 linear
Vector3 angular
MSG: geometry_msgs/AccelStamped
std_msgs/Header header
Accel accel
MSG: geometry_msgs/Wrench
Vector3 force
Vector3 torque
MSG: geometry_msgs/WrenchStamped
std_msgs/Header header
Wrench wrench
MSG: sensor_msgs/Imu
std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
MSG: sensor_msgs/JointState
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
MSG: sensor_msgs/MagneticField
std_msgs/Header header
geometry_msgs/Vector3 magnetic_field
float64[9] magnetic_field_covariance
MSG: sensor_msgs/FluidPressure
std_msgs/Header header
float64 fluid_pressure
float64 variance
MSG: sensor_msgs/Temperature
std_msgs/Header header
float64 temperature
float64 variance
MSG: sensor_msgs/Range
std_msgs/Header header
uint8 radiation_type
float32 field_of_view
float32 min_range
float32 max_range
float32 range
MSG: sensor_msgs/NavSatStatus
int8 status
uint16 service
MSG: sensor_msgs/NavSatFix
std_msgs/Header header
NavSatStatus status
float64 latitude
float64 longitude
float64 altitude
float64[9] position_covariance
uint8 position_covariance_type
MSG: nav_msgs/Odometry
std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
"""
