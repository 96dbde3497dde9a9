#!/usr/bin/env python3
"""Works out the known answers of key_schedule_test.cpp without libsodium: BLAKE2b from Python, AES-256-GCM by hand."""
import hashlib
import struct

VERSION = 2


def counting(first, size=32):
    return bytes((first + i) % 256 for i in range(size))


def blake(key, text, size=32, **extra):
    return hashlib.blake2b(text, key=key, digest_size=size, **extra).digest()


def subkey(master, number):
    return blake(master, b"", salt=struct.pack("<QQ", number, 0), person=b"hapton-k".ljust(16, b"\0"))


def gf(a, b):  # GF(2^8) of AES
    product = 0
    while b:
        product ^= a if b & 1 else 0
        a = (a << 1) ^ (0x11B if a & 0x80 else 0)
        b >>= 1
    return product


def make_sbox():
    box = []
    for x in range(256):
        inverse = next((y for y in range(256) if gf(x, y) == 1), 0)
        value = 0x63
        for turn in range(5):
            value ^= ((inverse << turn) | (inverse >> (8 - turn))) & 0xFF
        box.append(value)
    return box


SBOX = make_sbox()


def aes256(key, block):
    words, power = [list(key[4 * i:4 * i + 4]) for i in range(8)], 1
    for i in range(8, 60):
        word = words[-1][:]
        if i % 8 == 0:
            word = [SBOX[x] for x in word[1:] + word[:1]]
            word[0] ^= power
            power = gf(power, 2)
        elif i % 8 == 4:
            word = [SBOX[x] for x in word]
        words.append([x ^ y for x, y in zip(words[i - 8], word)])
    keys = [sum(words[4 * i:4 * i + 4], []) for i in range(15)]
    state = [x ^ k for x, k in zip(block, keys[0])]
    for turn in range(1, 15):
        state = [SBOX[state[(i + 4 * (i % 4)) % 16]] for i in range(16)]
        if turn < 14:
            state = [gf(state[c + r], 2) ^ gf(state[c + (r + 1) % 4], 3) ^ state[c + (r + 2) % 4] ^ state[c + (r + 3) % 4]
                     for c in range(0, 16, 4) for r in range(4)]
        state = [x ^ k for x, k in zip(state, keys[turn])]
    return bytes(state)


def ghash(key, text):
    h, total = int.from_bytes(key, "big"), 0
    for at in range(0, len(text), 16):
        x, v, total = total ^ int.from_bytes(text[at:at + 16], "big"), h, 0
        for bit in range(127, -1, -1):
            total ^= v if x >> bit & 1 else 0
            v = v >> 1 ^ (0xE1 << 120 if v & 1 else 0)
    return total.to_bytes(16, "big")


def xor(a, b):
    return bytes(x ^ y for x, y in zip(a, b))


def pad16(text):
    return text + bytes(-len(text) % 16)


def seal(key, connection, counter, text):
    header = bytes([0x08, VERSION, 4, 0]) + struct.pack("<IQ", connection, counter)
    nonce = bytes(4) + struct.pack("<Q", counter)
    stream = b"".join(aes256(key, nonce + struct.pack(">I", 2 + i)) for i in range(len(text) // 16 + 1))
    cipher = xor(text, stream)
    lengths = struct.pack(">QQ", 8 * len(header), 8 * len(cipher))
    digest = ghash(aes256(key, bytes(16)), pad16(header) + pad16(cipher) + lengths)
    return header + cipher + xor(digest, aes256(key, nonce + struct.pack(">I", 1)))


# FIPS 197, C.3
assert aes256(bytes(range(32)), bytes.fromhex("00112233445566778899aabbccddeeff")).hex() == "8ea2b7ca516745bfeafc49904b496089"

psk, client, hub = counting(1), counting(100), counting(200)
version = bytes([VERSION])
master = blake(psk, b"hapton session" + version + client + hub)
answers = {
    "HANDSHAKE": blake(psk, b"hapton handshake" + version),
    "CLIENT_TO_HUB": subkey(master, 1),
    "HUB_TO_CLIENT": subkey(master, 2),
    "ANSWER": subkey(master, 3),
    "TAG_OF_NONCE": blake(subkey(master, 3), client, 16),
    "SEALED": seal(subkey(master, 1), 0x01020304, 1, b"known answer, of two blocks"),
}
for name, value in answers.items():
    print(name, value.hex())
