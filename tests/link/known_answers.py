#!/usr/bin/env python3
"""Works out the known answers of key_schedule_test.cpp without libsodium: BLAKE2b from Python, ChaCha20-Poly1305 (RFC 8439) by hand."""
import hashlib
import struct

VERSION = 2


def counting(first, size=32):
    return bytes((first + i) % 256 for i in range(size))


def blake(key, text, size=32, **extra):
    return hashlib.blake2b(text, key=key, digest_size=size, **extra).digest()


def subkey(master, number):
    return blake(master, b"", salt=struct.pack("<QQ", number, 0), person=b"hapton-k".ljust(16, b"\0"))


def chacha_block(key, counter, nonce):
    state = list(struct.unpack("<4I", b"expand 32-byte k") + struct.unpack("<8I", key) + (counter,) + struct.unpack("<3I", nonce))
    work = state[:]

    def quarter(a, b, c, d):
        for x, y, z, turn in ((a, b, d, 16), (c, d, b, 12), (a, b, d, 8), (c, d, b, 7)):
            work[x] = (work[x] + work[y]) & 0xFFFFFFFF
            mixed = work[z] ^ work[x]
            work[z] = ((mixed << turn) | (mixed >> (32 - turn))) & 0xFFFFFFFF

    for _ in range(10):
        for a, b, c, d in ((0, 4, 8, 12), (1, 5, 9, 13), (2, 6, 10, 14), (3, 7, 11, 15),
                           (0, 5, 10, 15), (1, 6, 11, 12), (2, 7, 8, 13), (3, 4, 9, 14)):
            quarter(a, b, c, d)
    return struct.pack("<16I", *((x + y) & 0xFFFFFFFF for x, y in zip(work, state)))


def poly1305(key, text):
    r = int.from_bytes(key[:16], "little") & 0x0FFFFFFC0FFFFFFC0FFFFFFC0FFFFFFF
    total = 0
    for at in range(0, len(text), 16):
        total = (total + int.from_bytes(text[at:at + 16] + b"\x01", "little")) * r % ((1 << 130) - 5)
    return ((total + int.from_bytes(key[16:32], "little")) & ((1 << 128) - 1)).to_bytes(16, "little")


def pad16(text):
    return text + bytes(-len(text) % 16)


def seal(key, connection, counter, text):
    header = bytes([0x08, VERSION, 4, 0]) + struct.pack("<IQ", connection, counter)
    nonce = bytes(4) + struct.pack("<Q", counter)
    stream = b"".join(chacha_block(key, 1 + i, nonce) for i in range(len(text) // 64 + 1))
    cipher = bytes(a ^ b for a, b in zip(text, stream))
    lengths = struct.pack("<QQ", len(header), len(cipher))
    return header + cipher + poly1305(chacha_block(key, 0, nonce), pad16(header) + pad16(cipher) + lengths)


psk, client, hub = counting(1), counting(100), counting(200)
version = bytes([VERSION])
master = blake(psk, b"hapton session" + version + client + hub)
answers = {
    "HANDSHAKE": blake(psk, b"hapton handshake" + version),
    "CLIENT_TO_HUB": subkey(master, 1),
    "HUB_TO_CLIENT": subkey(master, 2),
    "ANSWER": subkey(master, 3),
    "TAG_OF_NONCE": blake(subkey(master, 3), client, 16),
    "SEALED": seal(subkey(master, 1), 0x01020304, 1, b"known answer"),
}
for name, value in answers.items():
    print(name, value.hex())
