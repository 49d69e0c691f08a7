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
# By each first byte, the value that it is by itself, or that it is none.
_NOT_SINGLE = object()
_SINGLE = [*range(0x80), *[_CONSTANTS.get(first, _NOT_SINGLE) for first in range(0x80, 0xE0)], *range(-0x20, 0)]
# Most numbers come in pairs and triples in single precision: what such a list begins with, and the list in one go.
_SINGLES = {length: (b"\xca" * length, struct.Struct(">" + "xf" * length)) for length in range(1, 16)}
_FLOAT = struct.Struct(">f").unpack_from
# Names of fields and words, which are the same in every message, as texts and as they are sent. So many are remembered.
_TEXTS, _PACKED = {}, {}
_MOST_TEXTS = 1000


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
    if _SINGLE[first] is not _NOT_SINGLE:
        return _SINGLE[first], at
    if first < 0x90:
        return _map(packed, at, first - 0x80)
    if first < 0xA0:
        return _list(packed, at, first - 0x90)
    if first < 0xC0:
        end = at + first - 0xA0
        return _text(packed[at:end]), end
    number = _NUMBERS.get(first)
    if number is not None:
        return number.unpack_from(packed, at)[0], at + number.size
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
    if length in _SINGLES:
        begin, numbers = _SINGLES[length]
        if packed[at : at + 5 * length : 5] == begin:
            return list(numbers.unpack_from(packed, at)), at + 5 * length
    values = []
    for _ in range(length):
        value, at = _value(packed, at)
        values.append(value)
    return values, at


def _map(packed, at, length):
    # What is most common is read here: a call costs more than what it does.
    fields = {}
    texts, single, not_single = _TEXTS, _SINGLE, _NOT_SINGLE
    for _ in range(length):
        first = packed[at]
        if 0xA0 <= first < 0xC0:
            end = at + first - 0x9F
            name = packed[at + 1 : end]
            name = texts[name] if name in texts else _text(name)
            at = end
        else:
            name, at = _value(packed, at)
        first = packed[at]
        value = single[first]
        if value is not not_single:
            fields[name] = value
            at += 1
        elif first == 0xCA:
            (fields[name],) = _FLOAT(packed, at + 1)
            at += 5
        elif first == 0x92 and packed[at + 1] == 0xCA and packed[at + 6] == 0xCA:
            fields[name] = [*_PAIR(packed, at)]
            at += 11
        elif 0xA0 <= first < 0xC0:
            end = at + first - 0x9F
            value = packed[at + 1 : end]
            fields[name] = texts[value] if value in texts else _text(value)
            at = end
        else:
            fields[name], at = _value(packed, at)
    return fields, at


_PAIR = struct.Struct(">xxfxf").unpack_from


def _text(packed):
    """A short text, which is likely to come again."""
    text = _TEXTS.get(packed)
    if text is None:
        text = str(packed, "utf-8")
        if len(_TEXTS) < _MOST_TEXTS:
            _TEXTS[packed] = text
    return text


def pack(value):
    """The bytes of a value."""
    if isinstance(value, str):
        packed = _PACKED.get(value)
        if packed is None:
            text = value.encode()
            packed = _head(0xA0, 32, 0xDA, len(text)) + text
            if len(text) < 32 and len(_PACKED) < _MOST_TEXTS:
                _PACKED[value] = packed
        return packed
    if isinstance(value, float):
        return struct.pack(">Bd", 0xCB, value)
    if isinstance(value, dict):
        fields = [_head(0x80, 16, 0xDE, len(value))]
        for name, field in value.items():
            fields.append(pack(name))
            fields.append(pack(field))
        return b"".join(fields)
    if isinstance(value, (list, tuple)):
        return _head(0x90, 16, 0xDC, len(value)) + b"".join(map(pack, value))
    if value is None:
        return b"\xc0"
    if isinstance(value, bool):
        return b"\xc3" if value else b"\xc2"
    if isinstance(value, int):
        if 0 <= value < 0x80:
            return bytes([value])
        return struct.pack(">BQ", 0xCF, value) if value >= 0 else struct.pack(">Bq", 0xD3, value)
    if isinstance(value, (bytes, bytearray)):
        return struct.pack(">BI", 0xC6, len(value)) + value
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
