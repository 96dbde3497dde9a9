#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

#include "tests/link/codec_fixture.h"

namespace hapton {
namespace {

TEST_F(CodecTest, NoTruncationPasses) {
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    const Bytes bytes = encode(random_.draw(kind));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      // A copy of exact size, so that the address sanitizer sees a read past the end.
      const DecodeStatus status = decode(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
      EXPECT_TRUE(status == DecodeStatus::truncated || status == DecodeStatus::unknown_message)
          << "kind " << kind << " cut to " << size << ": " << to_string(status);
    }
  }
}

TEST_F(CodecTest, NoCorruptedByteCrashesOrBreaksTheLimits) {
  std::size_t rejected = 0;
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    const Bytes bytes = encode(random_.draw(kind));
    for (std::size_t place = 0; place < bytes.size(); ++place) {
      for (int value = 0; value < 256; ++value) {
        Bytes corrupted = bytes;
        corrupted[place] = static_cast<std::byte>(value);
        if (decode(corrupted) == DecodeStatus::ok) {
          expect_within_limits(decoded_);
        } else {
          ++rejected;
        }
      }
    }
  }
  EXPECT_GT(rejected, 1000U);
}

TEST_F(CodecTest, RandomBytesNeverCrash) {
  constexpr int kDatagrams = 300'000;
  for (int i = 0; i < kDatagrams; ++i) {
    Bytes bytes(random_.bits() % 200);
    for (std::byte& byte : bytes) {
      byte = static_cast<std::byte>(random_.bits());
    }
    if (i % 2 == 0 && bytes.size() > 2) {  // half of the datagrams get past the check of the version
      bytes[0] = std::byte{0x08};
      bytes[1] = std::byte{kProtocolVersion};
    }
    if (decode(bytes) == DecodeStatus::ok) {
      expect_within_limits(decoded_);
    }
  }
}

TEST_F(CodecTest, MutatedDatagramsNeverCrash) {
  for (int i = 0; i < 200'000; ++i) {
    Bytes bytes = encode(random_.draw(random_.bits() % kKinds));
    for (std::uint64_t mutation = 0; mutation < 1 + random_.bits() % 4; ++mutation) {
      const std::size_t place = 2 + random_.bits() % (bytes.size() - 2);
      switch (random_.bits() % 3) {
        case 0:
          bytes[place] = static_cast<std::byte>(random_.bits());
          break;
        case 1:
          bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(place));
          break;
        default:
          bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(place), static_cast<std::byte>(random_.bits()));
      }
    }
    if (decode(bytes) == DecodeStatus::ok) {
      expect_within_limits(decoded_);
    }
  }
}

// A program with a key may send such times, through whatever fault of its own: their differences would not fit into 64 bits.
TEST_F(CodecTest, RejectsTimesThatNoClockHas) {
  constexpr std::int64_t kEarliest = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max();
  const auto expect_all = [&](std::int64_t time_ns, DecodeStatus status) {
    ObjectMove move{.source = 1, .end_ns = time_ns};
    ShapeStart start{.source = 1, .total = 3, .end_ns = time_ns};
    for (const Message& message : {Message(DeviceState{.sample_time_ns = time_ns}), Message(ForceCommand{.echo_sample_time_ns = time_ns}),
                                   Message(ForceCommand{.scene_time_ns = time_ns}), Message(ProbeState{.sample_time_ns = time_ns}),
                                   Message(ProbeState{.scene_time_ns = time_ns}), Message(FrameAck{.echo_sample_time_ns = time_ns})}) {
      EXPECT_EQ(round_trip(message), status) << time_ns << ", kind " << message.index();
    }
    if (time_ns >= 0) {
      EXPECT_EQ(round_trip(DeviceState{.scene_time_ns = time_ns}), status) << time_ns;
      EXPECT_EQ(round_trip(move), status) << time_ns;
      EXPECT_EQ(round_trip(start), status) << time_ns;
    }
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      Datagram datagram = random_.draw(kind);
      datagram.header.send_time_ns = time_ns;
      EXPECT_EQ(decode(encode(datagram)), status) << time_ns << ", kind " << kind;
    }
  };
  for (const std::int64_t time_ns : {-kMaxWireTimeNs, std::int64_t{-1}, std::int64_t{0}, kMaxWireTimeNs}) {
    expect_all(time_ns, DecodeStatus::ok);
  }
  for (const std::int64_t time_ns : {kEarliest, kEarliest + 1, -kMaxWireTimeNs - 1, kMaxWireTimeNs + 1, kLatest - 1, kLatest}) {
    expect_all(time_ns, DecodeStatus::bad_value);
  }
}

TEST_F(CodecTest, RejectsServoRatesThatNoHubHas) {
  for (const double rate_hz : {1e-300, kMinServoRateHz - 1, kMaxServoRateHz + 1, 1e9}) {
    EXPECT_EQ(round_trip(Welcome{true, rate_hz}), DecodeStatus::bad_value) << rate_hz;
    EXPECT_EQ(round_trip(LoopFacts{.servo_rate_hz = rate_hz}), DecodeStatus::bad_value) << rate_hz;
  }
  for (const double rate_hz : {0.0, kMinServoRateHz, kMaxServoRateHz}) {
    EXPECT_EQ(round_trip(Welcome{true, rate_hz}), DecodeStatus::ok) << rate_hz;
    EXPECT_EQ(round_trip(LoopFacts{.servo_rate_hz = rate_hz}), DecodeStatus::ok) << rate_hz;
  }
}

TEST_F(CodecTest, NeverUsesTheHeap) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  std::array<std::byte, kMaxDatagramBytes> buffer = {};
  const AllocationGuard guard;
  for (int repeat = 0; repeat < 50; ++repeat) {
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      const Datagram sent = random_.draw(kind);
      const std::size_t size = codec_.encode(sent, buffer);
      codec_.decode(std::span(buffer).first(size), decoded_);
    }
  }
  EXPECT_EQ(guard.count(), 0U);
}

TEST_F(CodecTest, AFalseLengthReservesNothing) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  // A ProbeState that claims 200 MB, and in it an unknown field that claims 100 MB.
  const Bytes bytes = {std::byte{0x08}, std::byte{kProtocolVersion},
                       std::byte{0xB2}, std::byte{0x01},
                       std::byte{0x80}, std::byte{0x84},
                       std::byte{0xAF}, std::byte{0x5F},
                       std::byte{0xA2}, std::byte{0x06},
                       std::byte{0x80}, std::byte{0xC2},
                       std::byte{0xD7}, std::byte{0x2F},
                       std::byte{0x00}, std::byte{0x00}};
  const AllocationGuard guard;
  EXPECT_EQ(decode(bytes), DecodeStatus::truncated);
  EXPECT_EQ(guard.count(), 0U);
}

TEST_F(CodecTest, HostileBytesDoNotReachTheHeapEither) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  std::array<std::byte, kMaxDatagramBytes> buffer = {};
  const AllocationGuard guard;
  for (int i = 0; i < 100'000; ++i) {
    const std::size_t size = codec_.encode(random_.draw(random_.bits() % kKinds), buffer);
    // Corrupt one byte and append rubbish, up to a full datagram.
    std::size_t length = size;
    while (length + 8 <= buffer.size() && random_.bits() % 64 != 0) {
      const std::uint64_t rubbish = random_.bits();
      std::memcpy(buffer.data() + length, &rubbish, sizeof rubbish);
      length += sizeof rubbish;
    }
    buffer[2 + random_.bits() % (length - 2)] = static_cast<std::byte>(random_.bits());
    codec_.decode(std::span(buffer).first(length), decoded_);
  }
  // Well-formed floods: in the messages 16 to 57 of the envelope, each field in turn is given or repeated until the datagram is full.
  for (int message = 16; message < 58; ++message) {
    for (int field = 1; field < 16; ++field) {
      for (const int wire_type : {0, 1, 2, 3, 5}) {
        std::size_t length = 0;
        const auto put = [&](int value) { buffer[length++] = static_cast<std::byte>(value); };
        put(0x08);
        put(static_cast<int>(kProtocolVersion));
        put(0x80 | ((message << 3 | 2) & 0x7F));
        put((message << 3 | 2) >> 7);
        constexpr int kBody = 1190;
        put(0x80 | (kBody & 0x7F));
        put(kBody >> 7);
        const std::size_t end = length + kBody;
        const std::size_t start = length;
        if (wire_type == 2) {
          constexpr int kPayload = 1184;
          put(field << 3 | 2);
          put(0x80 | (kPayload & 0x7F));
          put(kPayload >> 7);
        }
        while (length < end) {
          buffer[length] = wire_type == 2 || (length - start) % 9 != 0 ? std::byte{0} : static_cast<std::byte>(field << 3 | wire_type);
          ++length;
        }
        codec_.decode(std::span(buffer).first(length), decoded_);
      }
    }
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
