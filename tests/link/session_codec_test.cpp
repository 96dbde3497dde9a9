#include "link/session_codec.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/crc.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

namespace hapton {
namespace {

using Kind = SessionEntry::Kind;
using Status = SessionCodec::Status;

const std::array<std::byte, 3> kBytes = {std::byte{8}, std::byte{0}, std::byte{255}};

SessionEntry make_entry(Kind kind) {
  SessionEntry entry;
  entry.kind = kind;
  entry.time_ns = -5;
  switch (kind) {
    case Kind::received:
    case Kind::sent:
      entry.peer = {{1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 16}, 65535};
      entry.datagram = kBytes;
      break;
    case Kind::cycle:
      entry.cycle = {.sample = 1ULL << 60,
                     .late_ns = -3,
                     .written_n = Vec3(0.1, -0.0, 1e-300),
                     .written_nm = Vec3(0.0, 1e-3, -2.0),
                     .missed = 7,
                     .cause = MissCause::device_slow,
                     .device = CycleSample{-9, Vec3(1, -2, 1e-300), Quat(0.6, 0, -0.8, 0), 5},
                     .local = CycleLocal{Vec3(-1, 2, 3), Vec3(1e-3, 0, -2e-3), 3}};
      break;
    case Kind::fault:
      entry.fault = SessionFault::clamped;
      break;
    case Kind::dropped:
      entry.dropped = 12;
      break;
    case Kind::marker:
      entry.marker = {1ULL << 60, NodeRole::vision, "trial 1"};
      break;
    case Kind::end:
      break;
  }
  return entry;
}

void expect_equal(const SessionEntry& a, const SessionEntry& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.time_ns, b.time_ns);
  EXPECT_EQ(a.peer, b.peer);
  EXPECT_TRUE(std::equal(a.datagram.begin(), a.datagram.end(), b.datagram.begin(), b.datagram.end()));
  EXPECT_EQ(a.cycle.sample, b.cycle.sample);
  EXPECT_EQ(a.cycle.late_ns, b.cycle.late_ns);
  EXPECT_EQ(a.cycle.written_n, b.cycle.written_n);
  EXPECT_EQ(a.cycle.written_nm, b.cycle.written_nm);
  EXPECT_EQ(a.cycle.missed, b.cycle.missed);
  EXPECT_EQ(a.cycle.cause, b.cycle.cause);
  ASSERT_EQ(a.cycle.device.has_value(), b.cycle.device.has_value());
  if (a.cycle.device) {
    EXPECT_EQ(a.cycle.device->time_ns, b.cycle.device->time_ns);
    EXPECT_EQ(a.cycle.device->p_WD, b.cycle.device->p_WD);
    EXPECT_EQ(a.cycle.device->q_WT.coeffs(), b.cycle.device->q_WT.coeffs());
    EXPECT_EQ(a.cycle.device->buttons, b.cycle.device->buttons);
  }
  ASSERT_EQ(a.cycle.local.has_value(), b.cycle.local.has_value());
  if (a.cycle.local) {
    EXPECT_EQ(a.cycle.local->force_n, b.cycle.local->force_n);
    EXPECT_EQ(a.cycle.local->visual_offset_m, b.cycle.local->visual_offset_m);
    EXPECT_EQ(a.cycle.local->object, b.cycle.local->object);
  }
  EXPECT_EQ(a.fault, b.fault);
  EXPECT_EQ(a.dropped, b.dropped);
  EXPECT_EQ(a.marker.sample, b.marker.sample);
  EXPECT_EQ(a.marker.text, b.marker.text);
  if (a.kind == Kind::marker) {
    EXPECT_EQ(a.marker.source, b.marker.source);
  }
}

constexpr std::array kKinds = {Kind::received, Kind::sent, Kind::cycle, Kind::fault, Kind::dropped, Kind::marker, Kind::end};

TEST(SessionCodec, GivesBackEveryKindOfEntry) {
  SessionCodec codec;
  for (const Kind kind : kKinds) {
    std::string bytes;
    codec.append(make_entry(kind), bytes);
    SessionEntry read;
    const auto result = codec.read(bytes, read);
    ASSERT_EQ(result.status, Status::ok);
    EXPECT_EQ(result.bytes, bytes.size());
    expect_equal(make_entry(kind), read);
  }
}

// The bytes of a message in a file: length, message, CRC as field 15 (session.proto). The length is one byte, so it is at most 127.
std::string with_length_and_check(const std::string& message) {
  boost::crc_32_type crc;
  crc.process_bytes(message.data(), message.size());
  std::string bytes(1, static_cast<char>(message.size() + 5));
  bytes += message + '\x7D';
  for (int byte = 0; byte < 4; ++byte) bytes += static_cast<char>(crc.checksum() >> (8 * byte) & 0xFFU);
  return bytes;
}

// The CRC is right, but no socket can have such an address.
TEST(SessionCodec, AnAddressOfAnotherLengthAndAPortAbove65535AreDamage) {
  SessionCodec codec;
  std::string bytes;
  codec.append(make_entry(Kind::received), bytes);
  const std::string message = bytes.substr(1, bytes.size() - 6);
  ASSERT_EQ(with_length_and_check(message), bytes);
  SessionEntry read;
  ASSERT_EQ(codec.read(bytes, read).status, Status::ok);

  std::string port = message;
  const std::size_t at = port.find("\xFF\xFF\x03");  // 65535 as a varint
  ASSERT_NE(at, std::string::npos);
  port[at + 2] = 7;  // 131071
  EXPECT_EQ(codec.read(with_length_and_check(port), read).status, Status::damaged);

  std::string ip = message;
  const std::size_t begin = ip.find("\x0A\x10\x01\x02\x03");  // field 1, 16 bytes; the byte before is the size of the Datagram
  ASSERT_NE(begin, std::string::npos);
  --ip[begin - 1];
  --ip[begin + 1];
  ip.erase(begin + 2, 1);
  EXPECT_EQ(codec.read(with_length_and_check(ip), read).status, Status::damaged);
}

// An entry of a later version, with a field that this version does not know, is skipped. An entry with a field that is longer than the
// entry is damage.
TEST(SessionCodec, AnEntryOfAnUnknownKindIsPassedOver) {
  SessionCodec codec;
  SessionEntry read;
  const std::string bytes = with_length_and_check(std::string("\x08\x05\x70\x01", 4));  // field 1: a time; field 14: unknown
  const auto result = codec.read(bytes + "more", read);
  EXPECT_EQ(result.status, Status::unknown);
  EXPECT_EQ(result.bytes, bytes.size());
  EXPECT_EQ(codec.read(with_length_and_check(std::string("\x08\x05", 2)), read).status, Status::unknown) << "nor is one without a kind";
  EXPECT_EQ(codec.read(with_length_and_check("\x0A\x7F"), read).status, Status::damaged) << "a field that is longer than the entry";
  SessionHeader header;
  EXPECT_EQ(codec.read(with_length_and_check("\x0A\x7F"), header).status, Status::damaged);
}

TEST(SessionCodec, AMarkerThatNoNodeMaySendIsDamage) {
  SessionCodec codec;
  for (const std::string_view text : {"", "a\nb", "\xFF"}) {  // a reader gives out no text that an export cannot write
    SessionEntry entry = make_entry(Kind::marker);
    entry.marker.text = text;
    std::string bytes;
    codec.append(entry, bytes);
    SessionEntry read;
    EXPECT_EQ(codec.read(bytes, read).status, Status::damaged) << text;
  }
}

// Recordings of earlier versions have no sample of the device, and a local force is only there if io_node computed the force.
TEST(SessionCodec, ACycleMayLackTheDevicesSampleAndALocalForce) {
  SessionCodec codec;
  SessionEntry entry = make_entry(Kind::cycle);
  entry.cycle.device.reset();
  entry.cycle.local.reset();
  std::string bytes;
  codec.append(entry, bytes);
  codec.append(make_entry(Kind::cycle), bytes);
  SessionEntry read;
  const auto first = codec.read(bytes, read);
  ASSERT_EQ(first.status, Status::ok);
  expect_equal(entry, read);
  ASSERT_EQ(codec.read(std::string_view(bytes).substr(first.bytes), read).status, Status::ok);
  expect_equal(make_entry(Kind::cycle), read);
}

// The file counts objects from 1, and its counter can be larger than any index.
TEST(SessionCodec, AnObjectNumberThatNoSceneCanHaveIsReadAsNoObject) {
  SessionCodec codec;
  constexpr std::int32_t kLargest = std::numeric_limits<std::int32_t>::max();
  for (const auto& [written, read_back] : {std::pair{-1, -1}, {0, 0}, {1, 1}, {kLargest - 1, kLargest - 1}, {kLargest, -1}}) {
    SessionEntry entry = make_entry(Kind::cycle);
    entry.cycle.local->object = written;
    std::string bytes;
    codec.append(entry, bytes);
    SessionEntry read;
    ASSERT_EQ(codec.read(bytes, read).status, Status::ok);
    EXPECT_EQ(read.cycle.local->object, read_back) << written;
  }
}

TEST(SessionCodec, GivesBackAHeader) {
  SessionCodec codec;
  const SessionHeader header{"0.1.0", 5, 6, 7, "command-timeout", {{"rate", "1000"}, {"device", "simulated"}}, true};
  std::string bytes;
  codec.append(header, bytes);
  SessionHeader read;
  ASSERT_EQ(codec.read(bytes, read).status, Status::ok);
  EXPECT_EQ(read.build, header.build);
  EXPECT_EQ(read.start_ns, 5);
  EXPECT_EQ(read.start_unix_ns, 6);
  EXPECT_EQ(read.session, 7U);
  EXPECT_EQ(read.fault, "command-timeout");
  EXPECT_EQ(read.settings, header.settings);
  EXPECT_TRUE(read.has_end);
}

TEST(SessionCodec, EveryCutIsDetected) {
  SessionCodec codec;
  for (const Kind kind : kKinds) {
    std::string bytes;
    codec.append(make_entry(kind), bytes);
    SessionEntry read;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_EQ(codec.read(std::string_view(bytes).substr(0, size), read).status, Status::cut) << size;
    }
  }
}

TEST(SessionCodec, EveryChangedBitIsDetected) {
  SessionCodec codec;
  for (const Kind kind : kKinds) {
    std::string bytes;
    codec.append(make_entry(kind), bytes);
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      std::string changed = bytes;
      changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << (bit % 8)));
      SessionEntry read;
      EXPECT_NE(codec.read(changed, read).status, Status::ok) << bit;
    }
  }
}

// File names may hold any bytes. protobuf does not read a message with a text that is not UTF-8, so the recording could not be read.
TEST(SessionCodec, ATextThatIsNotUtf8LeavesTheRecordingReadable) {
  SessionCodec codec;
  std::string bytes;
  codec.append(SessionHeader{.build = "0.1.0 \xFF", .session = 7, .fault = "\x80", .settings = {{"trajectory", "caf\xE9.csv"}}}, bytes);
  SessionHeader read;
  ASSERT_EQ(codec.read(bytes, read).status, SessionCodec::Status::ok);
  EXPECT_EQ(read.session, 7U);
  ASSERT_EQ(read.settings.size(), 1U);
  EXPECT_EQ(read.settings[0].second, "caf\xC3\xA9.csv");
}

}  // namespace
}  // namespace hapton
