#!/usr/bin/env python3
"""Computes the known answers of key_schedule_test.cpp without libsodium. BLAKE2b, SHA-256 and HMAC are from Python's standard library;
AES-256-GCM and X25519 are implemented here."""
import hashlib
import hmac
import struct

VERSION = 3  # kProtocolVersion


def counting(first, size=32):
    return bytes((first + i) % 256 for i in range(size))


def blake(key, text, size=32):
    return hashlib.blake2b(text, key=key, digest_size=size).digest()


def gf(a, b):  # product in the field GF(2^8) of AES
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
        for shift in range(5):
            value ^= ((inverse << shift) | (inverse >> (8 - shift))) & 0xFF
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
    for round_number in range(1, 15):
        state = [SBOX[state[(i + 4 * (i % 4)) % 16]] for i in range(16)]
        if round_number < 14:
            state = [gf(state[c + r], 2) ^ gf(state[c + (r + 1) % 4], 3) ^ state[c + (r + 2) % 4] ^ state[c + (r + 3) % 4]
                     for c in range(0, 16, 4) for r in range(4)]
        state = [x ^ k for x, k in zip(state, keys[round_number])]
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


def gcm(key, counter, ad, text):
    nonce = bytes(4) + struct.pack(">Q", counter)
    stream = b"".join(aes256(key, nonce + struct.pack(">I", 2 + i)) for i in range(len(text) // 16 + 1))
    cipher = xor(text, stream)
    lengths = struct.pack(">QQ", 8 * len(ad), 8 * len(cipher))
    digest = ghash(aes256(key, bytes(16)), pad16(ad) + pad16(cipher) + lengths)
    return cipher + xor(digest, aes256(key, nonce + struct.pack(">I", 1)))


def seal(key, connection, counter, text):
    header = bytes([0x08, VERSION, 4, 0]) + struct.pack("<IQ", connection, counter)
    return header + gcm(key, counter, header, text)


P = 2**255 - 19


def x25519(secret, point):  # RFC 7748, section 5
    k = int.from_bytes(secret, "little") & ~7 & ~(1 << 255) | 1 << 254
    u = int.from_bytes(point, "little") & (1 << 255) - 1
    x2, z2, x3, z3, swapped = 1, 0, u, 1, 0
    for t in range(254, -1, -1):
        bit = k >> t & 1
        if swapped ^ bit:
            x2, x3, z2, z3 = x3, x2, z3, z2
        swapped = bit
        a, b, c, d = x2 + z2, x2 - z2, x3 + z3, x3 - z3
        da, cb, aa, bb = d * a % P, c * b % P, a * a % P, b * b % P
        e = aa - bb
        x3, z3 = (da + cb) ** 2 % P, u * (da - cb) ** 2 % P
        x2, z2 = aa * bb % P, e * (aa + 121665 * e) % P
    if swapped:
        x2, z2 = x3, z3
    return (x2 * pow(z2, P - 2, P) % P).to_bytes(32, "little")


BASE = (9).to_bytes(32, "little")


def hkdf(ck, text, count):
    temp, outs, last = hmac.digest(ck, text, "sha256"), [], b""
    for i in range(count):
        last = hmac.digest(temp, last + bytes([i + 1]), "sha256")
        outs.append(last)
    return outs


class Noise:  # the handshake pattern NNpsk0; one object plays both sides
    def __init__(self, psk, prologue):
        self.h = self.ck = b"Noise_NNpsk0_25519_AESGCM_SHA256"
        self.mix_hash(prologue)
        self.ck, temp, self.k = hkdf(self.ck, psk, 3)
        self.mix_hash(temp)
        self.n = 0

    def mix_hash(self, text):
        self.h = hashlib.sha256(self.h + text).digest()

    def mix_key(self, text):
        self.ck, self.k = hkdf(self.ck, text, 2)
        self.n = 0

    def message(self, secret, peer_public, payload):
        public = x25519(secret, BASE)
        self.mix_hash(public)
        self.mix_key(public)
        if peer_public:
            self.mix_key(x25519(secret, peer_public))
        sealed = gcm(self.k, self.n, self.h, payload)
        self.n += 1
        self.mix_hash(sealed)
        return public + sealed


# FIPS 197, C.3
assert aes256(bytes(range(32)), bytes.fromhex("00112233445566778899aabbccddeeff")).hex() == "8ea2b7ca516745bfeafc49904b496089"
# RFC 7748, 5.2
assert x25519(bytes.fromhex("a546e36bf0527c9d3b16154b82465edd62144c0ac1fc5a18506a2244ba449ac4"), bytes.fromhex(
    "e6db6867583030db3594c1a424b15f7c726624ec26b3353b10a903a6d0ab1c4c")).hex() == (
    "c3da55379de9c6908e94ea4df28d084f32eccf03491c71f754b4075577a28552")

master = counting(1)
version = bytes([VERSION])
roles = {role: blake(master, b"hapton role " + role) for role in (b"haptics", b"vision", b"tool", b"operator")}
role_key = roles[b"haptics"]
handshake_key = blake(role_key, b"hapton handshake" + version)
psk = blake(role_key, b"hapton psk" + version)
prologue = bytes([0x08, VERSION, 1, 0, 2, 0, 0, 0]) + struct.pack("<Qq", 0x1122334455667788, 1234567890)
noise = Noise(psk, prologue)
node_secret, hub_secret = counting(100), counting(200)
first = noise.message(node_secret, None, b"")
second = noise.message(hub_secret, first[:32], struct.pack("<I", 0x01020304))
client_to_hub, hub_to_client = hkdf(noise.ck, b"", 2)
answers = {
    **{role.decode().upper(): key for role, key in roles.items()},
    "HANDSHAKE": handshake_key,
    "PSK": psk,
    "TAG": blake(handshake_key, prologue, 16),
    "FIRST": first,
    "SECOND": second,
    "CLIENT_TO_HUB": client_to_hub,
    "HUB_TO_CLIENT": hub_to_client,
    "SEALED": seal(client_to_hub, 0x01020304, 1, b"known answer, of two blocks"),
}
for name, value in answers.items():
    print(name, value.hex())
