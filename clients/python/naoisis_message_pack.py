"""MessagePack for programs that play: needs Python 3.8 and nothing else, and is quicker where the package `msgpack` is installed.

`pack` makes bytes of a value, `unpack` a value of bytes. What JSON has, and bytes.
"""

import struct

# By the first byte of a value: the bytes of the length that follows, and of what.
_LENGTHS = {
    **{0xC4: (1, "bytes"), 0xC5: (2, "bytes"), 0xC6: (4, "bytes"), 0xD9: (1, "text"), 0xDA: (2, "text"), 0xDB: (4, "text")},
    **{0xDC: (2, "list"), 0xDD: (4, "list"), 0xDE: (2, "map"), 0xDF: (4, "map")},
}
_FORMATS = {0xCA: ">f", 0xCB: ">d", 0xCC: ">B", 0xCD: ">H", 0xCE: ">I", 0xCF: ">Q", 0xD0: ">b", 0xD1: ">h", 0xD2: ">i", 0xD3: ">q"}
_NUMBERS = {first: struct.Struct(form) for first, form in _FORMATS.items()}
_CONSTANTS = {0xC0: None, 0xC2: False, 0xC3: True}


def unpack(packed):
    """The value that these bytes are."""
    value, end = _value(packed, 0)
    if end != len(packed):
        raise ValueError("more than one MessagePack value")
    return value


def _value(packed, at):
    """The value that begins at this byte, and where it ends."""
    first = packed[at]
    at += 1
    number = _NUMBERS.get(first)
    if number is not None:
        return number.unpack_from(packed, at)[0], at + number.size
    if first < 0x80:
        return first, at
    if first >= 0xE0:
        return first - 256, at
    if first < 0x90:
        return _map(packed, at, first - 0x80)
    if first < 0xA0:
        return _list(packed, at, first - 0x90)
    if first < 0xC0:
        end = at + first - 0xA0
        return str(packed[at:end], "utf-8"), end
    if first in _CONSTANTS:
        return _CONSTANTS[first], at
    if first not in _LENGTHS:
        raise ValueError(f"there is no MessagePack value that begins with {first:#x}")
    size, kind = _LENGTHS[first]
    length = int.from_bytes(packed[at : at + size], "big")
    at += size
    if kind == "map":
        return _map(packed, at, length)
    if kind == "list":
        return _list(packed, at, length)
    content = packed[at : at + length]
    return content if kind == "bytes" else str(content, "utf-8"), at + length


def _list(packed, at, length):
    values = []
    for _ in range(length):
        value, at = _value(packed, at)
        values.append(value)
    return values, at


def _map(packed, at, length):
    fields = {}
    for _ in range(length):
        name, at = _value(packed, at)
        fields[name], at = _value(packed, at)
    return fields, at


def pack(value):
    """The bytes of a value."""
    if value is None:
        return b"\xc0"
    if isinstance(value, bool):
        return b"\xc3" if value else b"\xc2"
    if isinstance(value, float):
        return struct.pack(">Bd", 0xCB, value)
    if isinstance(value, int):
        if 0 <= value < 0x80:
            return bytes([value])
        return struct.pack(">BQ", 0xCF, value) if value >= 0 else struct.pack(">Bq", 0xD3, value)
    if isinstance(value, str):
        text = value.encode()
        return _head(0xA0, 32, 0xDA, len(text)) + text
    if isinstance(value, (bytes, bytearray)):
        return struct.pack(">BI", 0xC6, len(value)) + value
    if isinstance(value, dict):
        fields = b"".join(pack(name) + pack(field) for name, field in value.items())
        return _head(0x80, 16, 0xDE, len(value)) + fields
    if isinstance(value, (list, tuple)):
        return _head(0x90, 16, 0xDC, len(value)) + b"".join(map(pack, value))
    raise TypeError(f"{value!r} has no form in MessagePack")


def _head(short, fewer_than, first, length):
    """What begins a text, list or map of this length."""
    if length < fewer_than:
        return bytes([short + length])
    return struct.pack(">BH", first, length) if length < 1 << 16 else struct.pack(">BI", first + 1, length)


try:
    from msgpack import packb as pack, unpackb as unpack  # noqa: F811
except ImportError:
    pass
