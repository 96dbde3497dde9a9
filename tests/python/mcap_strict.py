"""Reads an MCAP file as https://mcap.dev/spec says, and raises at whatever is not as it says. Written from the specification alone."""
import struct
import zlib

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = 0x0B, 0x0C, 0x0D, 0x0E, 0x0F


def check(condition, what):
    if not condition:
        raise ValueError(what)


class Fields:
    """The fields of one record, front to back."""

    def __init__(self, data):
        self.data = data
        self.at = 0

    def number(self, size):
        check(self.at + size <= len(self.data), "a record ends within a number")
        value = int.from_bytes(self.data[self.at:self.at + size], "little")
        self.at += size
        return value

    def raw(self, size):
        check(self.at + size <= len(self.data), "a record ends within a text")
        self.at += size
        return self.data[self.at - size:self.at]

    def text(self):
        return self.raw(self.number(4)).decode("utf-8")

    def pairs(self, key, value):
        inner = Fields(self.raw(self.number(4)))
        pairs = []
        while inner.at < len(inner.data):
            pairs.append((key(inner), value(inner)))
        check(len(pairs) == len(set(pairs)), "a pair stands twice")
        return pairs

    def end(self):
        check(self.at == len(self.data), "a record is longer than its fields")


def records(data, begin, end):
    """(type, content, offset, length with type and length) of each record in between."""
    at = begin
    while at < end:
        check(at + 9 <= end, "the file ends within a record's head")
        length = int.from_bytes(data[at + 1:at + 9], "little")
        check(at + 9 + length <= end, "the file ends within a record")
        yield data[at], data[at + 9:at + 9 + length], at, 9 + length
        at += 9 + length


class McapFile:
    """schemas: number -> (name, encoding, data); channels: number -> (schema, topic, encoding); messages: in the order of the file,
    (topic, sequence, log_time, publish_time, data); metadata: name -> dict."""

    def __init__(self, path):
        with open(path, "rb") as file:
            self.data = file.read()
        self.schemas, self.channels, self.messages, self.metadata = {}, {}, [], {}
        self.chunks, self.indexes, self.metadata_at = [], {}, []
        check(self.data.startswith(MAGIC) and self.data.endswith(MAGIC) and len(self.data) >= 2 * len(MAGIC) + 29, "no magic")
        footer_at = len(self.data) - len(MAGIC) - 29
        summary, offsets = self.read_footer(footer_at)
        self.read_data(summary if summary else footer_at)
        self.read_summary(summary, offsets, footer_at)

    def read_footer(self, at):
        check(self.data[at] == FOOTER and int.from_bytes(self.data[at + 1:at + 9], "little") == 20, "no footer")
        fields = Fields(self.data[at + 9:at + 29])
        summary, offsets, crc = fields.number(8), fields.number(8), fields.number(4)
        check(len(MAGIC) < summary <= offsets <= at, "the summary is not where the footer says")
        check(crc == zlib.crc32(self.data[summary:at + 25]), "the summary's checksum does not hold")
        return summary, offsets

    def read_data(self, end):
        all_records = list(records(self.data, len(MAGIC), end))
        check(all_records[0][0] == HEADER, "the first record is not a header")
        check(all_records[-1][0] == DATA_END, "the last record of the data is not a data end")
        waiting = None  # the chunk whose message indexes come now
        for op, content, at, length in all_records:
            fields = Fields(content)
            check(waiting is None or op == MESSAGE_INDEX or not waiting["channels"], "a channel of a chunk has no message index")
            if op == HEADER:
                check(at == len(MAGIC), "a second header")
                self.profile, self.library = fields.text(), fields.text()
                fields.end()
            elif op == CHUNK:
                waiting = self.read_chunk(fields, at, length)
            elif op == MESSAGE_INDEX:
                self.read_message_index(fields, at, length, waiting)
            elif op == METADATA:
                name = fields.text()
                self.metadata[name] = dict(fields.pairs(Fields.text, Fields.text))
                self.metadata_at.append((at, length, name))
                fields.end()
            elif op == DATA_END:
                check(at + length == end, "data behind its end")
                check(fields.number(4) == zlib.crc32(self.data[:at]), "the checksum of the data does not hold")
                fields.end()
            elif op in (SCHEMA, CHANNEL):
                self.read_definition(op, fields)
            else:
                raise ValueError(f"a record of type {op} in the data")

    def read_definition(self, op, fields):
        number = fields.number(2)
        if op == SCHEMA:
            check(number != 0, "schema 0")
            size = None
            entry = (fields.text(), fields.text(), fields.raw(fields.number(4)))
            known = self.schemas
        else:
            entry = (fields.number(2), fields.text(), fields.text())
            check(entry[0] == 0 or entry[0] in self.schemas, "a channel of an unknown schema")
            check(fields.pairs(Fields.text, Fields.text) == [], "metadata of a channel")
            known = self.channels
        fields.end()
        check(known.setdefault(number, entry) == entry, "two definitions of one number")

    def read_chunk(self, fields, at, length):
        first, last, size, crc = fields.number(8), fields.number(8), fields.number(8), fields.number(4)
        check(fields.text() == "", "a compressed chunk")
        content = fields.raw(fields.number(8))
        fields.end()
        check(len(content) == size, "a chunk has another size than it says")
        check(crc == zlib.crc32(content), "a chunk's checksum does not hold")
        chunk = {"at": at, "length": length, "first": first, "last": last, "size": size, "channels": {}, "index": {}, "index_length": 0}
        times = []
        for op, message, offset, _ in records(content, 0, len(content)):
            check(op == MESSAGE, "a chunk has more than messages")
            inner = Fields(message)
            channel, sequence, log_time, publish_time = (inner.number(n) for n in (2, 4, 8, 8))
            check(channel in self.channels, "a message of an unknown channel")
            self.messages.append((self.channels[channel][1], sequence, log_time, publish_time, message[inner.at:]))
            chunk["channels"].setdefault(channel, []).append((log_time, offset))
            times.append(log_time)
        check(times and min(times) == first and max(times) == last, "a chunk has other times than it says")
        self.chunks.append(chunk)
        return chunk

    def read_message_index(self, fields, at, length, chunk):
        channel = fields.number(2)
        entries = fields.pairs(lambda f: f.number(8), lambda f: f.number(8))
        fields.end()
        check(chunk is not None and channel in chunk["channels"], "a message index of no chunk")
        check(sorted(chunk["channels"].pop(channel)) == sorted(entries), "a message index is not its chunk's")
        check([time for time, _ in entries] == sorted(time for time, _ in entries), "a message index is not sorted")
        chunk["index"][channel] = at
        chunk["index_length"] += length

    def read_summary(self, summary, offsets, end):
        groups = []
        indexes, metadata, definitions = [], [], {SCHEMA: {}, CHANNEL: {}}
        for op, content, at, length in records(self.data, summary, offsets):
            if groups and groups[-1][0] == op:
                groups[-1][2] += length
            else:
                check(op not in [group[0] for group in groups], "the summary is not grouped by type")
                groups.append([op, at, length])
            fields = Fields(content)
            if op in (SCHEMA, CHANNEL):
                definitions[op][int.from_bytes(content[:2], "little")] = content
                self.read_definition(op, fields)
            elif op == STATISTICS:
                self.read_statistics(fields)
            elif op == CHUNK_INDEX:
                first, last, chunk_at, chunk_length = (fields.number(8) for _ in range(4))
                index = dict(fields.pairs(lambda f: f.number(2), lambda f: f.number(8)))
                index_length, compression, size, whole = fields.number(8), fields.text(), fields.number(8), fields.number(8)
                fields.end()
                check(compression == "" and size == whole, "a chunk index says compressed")
                indexes.append((first, last, chunk_at, chunk_length, index, index_length, size))
            elif op == METADATA_INDEX:
                metadata.append((fields.number(8), fields.number(8), fields.text()))
                fields.end()
            else:
                raise ValueError(f"a record of type {op} in the summary")
        check(set(definitions[SCHEMA]) == set(self.schemas) and set(definitions[CHANNEL]) == set(self.channels), "the summary lacks some")
        check(indexes == [(c["first"], c["last"], c["at"], c["length"], c["index"], c["index_length"], c["size"]) for c in self.chunks],
              "the chunk indexes are not those of the chunks")
        check(metadata == self.metadata_at, "the metadata index is not that of the metadata")
        listed = []
        for op, content, _, _ in records(self.data, offsets, end):
            check(op == SUMMARY_OFFSET, "the summary offsets have others among them")
            fields = Fields(content)
            listed.append([fields.number(1), fields.number(8), fields.number(8)])
            fields.end()
        check(listed == groups, "the summary offsets are not those of the groups")

    def read_statistics(self, fields):
        names = [(8, len(self.messages)), (2, len(self.schemas)), (4, len(self.channels)), (4, 0), (4, len(self.metadata)), (4, len(self.chunks)),
                 (8, min((m[2] for m in self.messages), default=0)), (8, max((m[2] for m in self.messages), default=0))]
        for size, value in names:
            check(fields.number(size) == value, "the statistics are wrong")
        counts = dict(fields.pairs(lambda f: f.number(2), lambda f: f.number(8)))
        fields.end()
        for number, (_, topic, _) in self.channels.items():
            check(counts[number] == sum(m[0] == topic for m in self.messages), "a channel's count is wrong")
