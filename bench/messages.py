"""MCAP files as streams of JSON messages: what Gantry needs of the format, and its errors in plain words.

The format: https://mcap.dev/spec. Channels carry JSON Schemas, so that viewers such as Foxglove open the files.
"""

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import mcap.exceptions
import mcap.reader
import mcap.records
import mcap.stream_reader
import mcap.writer
import zstandard

from contracts import InputError

PROFILE = "gantry"
_BROKEN = (  # what the reader raises on a broken file
    mcap.exceptions.McapError,
    zstandard.ZstdError,
    struct.error,
    ValueError,
    KeyError,
    MemoryError,
)


@dataclass(frozen=True)
class Message:
    """One message: JSON ``data`` on ``topic``; ``index`` is the step's, ``time_ns`` its time."""

    topic: str
    index: int
    time_ns: int
    data: bytes


class MessageWriter:
    """Appends messages to a stream, compressed; ``finish`` writes the index."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._writer = mcap.writer.Writer(stream)
        self._writer.start(profile=PROFILE, library="gantry-bench")
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}

    def write(self, message: Message, schema: dict[str, Any]) -> None:
        """Append ``message``; ``schema`` is the JSON Schema of its topic, with a title."""
        if message.topic not in self._channels:
            self._channels[message.topic] = self._writer.register_channel(message.topic, "json", self._schema(schema))
        self._writer.add_message(
            self._channels[message.topic],
            log_time=message.time_ns,
            data=message.data,
            publish_time=message.time_ns,
            sequence=message.index,
        )

    def finish(self) -> None:
        """Write what is still buffered, and the index."""
        self._writer.finish()

    def _schema(self, schema: dict[str, Any]) -> int:
        title: str = schema["title"]
        if title not in self._schemas:
            text = json.dumps(schema).encode()
            self._schemas[title] = self._writer.register_schema(title, "jsonschema", text)
        return self._schemas[title]


class MessageReader:
    """The messages of a file in the order in which they were written.

    ``damage`` says, once they have been read, what was wrong with the file: ``""`` if nothing. Iterating raises
    InputError if the file is none of Gantry's.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.damage = ""

    def __iter__(self) -> Iterator[Message]:
        self.damage = ""
        with self._path.open("rb") as stream:
            records = mcap.stream_reader.StreamReader(stream, validate_crcs=True).records
            header = self._first(records)
            if not isinstance(header, mcap.records.Header) or header.profile != PROFILE:
                raise InputError(f"{self._path} is an MCAP file, but no recording of Gantry")
            try:
                yield from _messages(records)
            except mcap.exceptions.EndOfFile:
                self.damage = "is cut short"
            except _BROKEN:
                self.damage = "is damaged"

    def topics(self) -> tuple[str, ...]:
        """The topics in the order in which they first occur; read from the file's index.

        Raises InputError if the file has none, so if it is cut short or none of Gantry's.
        """
        with self._path.open("rb") as stream:
            try:
                summary = mcap.reader.SeekingReader(stream).get_summary()
            except (*_BROKEN, OSError) as error:
                raise InputError(f"{self._path} has no readable index: it is cut short or no MCAP file") from error
        if summary is None:
            raise InputError(f"{self._path} has no index: it is cut short")
        return tuple(channel.topic for _, channel in sorted(summary.channels.items()))

    def _first(self, records: Iterator[object]) -> object:
        try:
            return next(records)
        except _BROKEN as error:
            raise InputError(f"{self._path} is no MCAP file") from error


def _messages(records: Iterator[object]) -> Iterator[Message]:
    topics: dict[int, str] = {}
    for record in records:
        if isinstance(record, mcap.records.Channel):
            topics[record.id] = record.topic
        if isinstance(record, mcap.records.Message):
            yield Message(topics[record.channel_id], record.sequence, record.log_time, record.data)
