#include "link/round_trip_codec.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "hapton.pb.h"
#include "tests/link/codec_fixture.h"

namespace hapton {
namespace {

class FixedCodec : public testing::Test {
 protected:
  Bytes write(const Datagram& datagram) {
    std::array<std::byte, kMaxDatagramBytes> bytes;
    const std::size_t size = encode_round_trip(datagram, bytes);
    return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
  }
  // The datagram as a later build might write it: with an unknown field in front, which only the general decoder skips.
  static Bytes with_unknown_field(const Bytes& bytes) {
    Bytes longer(bytes.begin(), bytes.begin() + 2);
    for (const unsigned byte : {0x78U, 0x01U}) longer.push_back(static_cast<std::byte>(byte));  // field 15, varint
    longer.insert(longer.end(), bytes.begin() + 2, bytes.end());
    return longer;
  }
  // Checks that the general decoder accepts what this decoder accepts, and reads the same. Returns whether this decoder accepts it.
  bool expect_as_general(const Bytes& bytes) {
    Datagram fast;
    Datagram general;
    if (!decode_round_trip(bytes, fast)) return false;
    const Bytes longer = with_unknown_field(bytes);
    EXPECT_FALSE(decode_round_trip(longer, general));
    EXPECT_EQ(codec_.decode(longer, general), DecodeStatus::ok);
    EXPECT_EQ(write(general), write(fast));
    EXPECT_EQ(general.message.index(), fast.message.index());
    return true;
  }

  RandomDatagrams random_{kCodecSeed};
  Codec codec_;
};

TEST_F(FixedCodec, WritesWhatProtobufWrites) {
  for (int i = 0; i < 4'000; ++i) {
    const Bytes bytes = write(random_.draw(i % 2 == 0 ? kDeviceState : kForceCommand));
    ASSERT_FALSE(bytes.empty());
    wire::Envelope envelope;
    ASSERT_TRUE(envelope.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
    const std::string reference = envelope.SerializeAsString();
    ASSERT_EQ(reference.size(), bytes.size()) << i;
    ASSERT_EQ(std::memcmp(reference.data(), bytes.data(), bytes.size()), 0) << i;
  }
}

TEST_F(FixedCodec, ReadsWhatTheGeneralDecoderReads) {
  for (int i = 0; i < 4'000; ++i) {
    const Datagram sent = random_.draw(i % 2 == 0 ? kDeviceState : kForceCommand);
    const Bytes bytes = write(sent);
    ASSERT_TRUE(expect_as_general(bytes)) << i;
    Datagram read;
    ASSERT_TRUE(decode_round_trip(bytes, read));
    ASSERT_EQ(write(read), bytes);
    EXPECT_EQ(read.header.session, sent.header.session);
    EXPECT_EQ(read.header.sender, sent.header.sender);
    EXPECT_EQ(read.header.sequence, sent.header.sequence);
    EXPECT_EQ(read.header.send_time_ns, sent.header.send_time_ns);
  }
}

TEST_F(FixedCodec, LeavesOtherMessagesToTheGeneralCodec) {
  for (std::size_t kind = 0; kind < kKinds; ++kind) {
    const Datagram sent = random_.draw(kind);
    const bool is_fixed = kind == kDeviceState || kind == kForceCommand;
    EXPECT_EQ(!write(sent).empty(), is_fixed) << kind;
    std::array<std::byte, kMaxDatagramBytes> bytes;
    const std::size_t size = codec_.encode(sent, bytes);
    ASSERT_NE(size, 0U);
    Datagram read;
    EXPECT_EQ(decode_round_trip(std::span(bytes).first(size), read), is_fixed) << kind;
  }
}

// With bytes changed, cut off, added or removed, this decoder accepts nothing that the general decoder rejects.
TEST_F(FixedCodec, AcceptsNothingThatTheGeneralDecoderRejects) {
  int accepted = 0;
  for (int i = 0; i < 60'000; ++i) {
    Bytes bytes = write(random_.draw(i % 2 == 0 ? kDeviceState : kForceCommand));
    const auto place = [&] { return static_cast<std::ptrdiff_t>(random_.bits() % bytes.size()); };
    switch (random_.bits() % 5) {
      case 0:
        bytes[static_cast<std::size_t>(place())] ^= static_cast<std::byte>(1U << (random_.bits() % 8));
        break;
      case 1:
        bytes[static_cast<std::size_t>(place())] = static_cast<std::byte>(random_.bits());
        break;
      case 2:
        bytes.resize(static_cast<std::size_t>(place()) + 1);
        break;
      case 3:
        bytes.insert(bytes.begin() + place(), static_cast<std::byte>(random_.bits()));
        break;
      default:
        bytes.erase(bytes.begin() + place());
    }
    accepted += expect_as_general(bytes) ? 1 : 0;
    ASSERT_FALSE(testing::Test::HasFailure()) << i;
  }
  EXPECT_GT(accepted, 5'000) << "most bytes are of numbers, which may be any";
  EXPECT_LT(accepted, 30'000) << "a datagram that is cut off or longer is another one";
}

TEST_F(FixedCodec, RejectsValuesThatTheContractRulesOut) {
  const auto is_accepted = [&](const Message& message) {
    Datagram read;
    return decode_round_trip(write({{}, message}), read);
  };
  EXPECT_TRUE(is_accepted(DeviceState{}));
  EXPECT_TRUE(is_accepted(ForceCommand{}));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.1e9}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 bad_vector = Vec3::Zero();
      bad_vector[axis] = bad;
      EXPECT_FALSE(is_accepted(DeviceState{.p_WD = bad_vector}));
      EXPECT_FALSE(is_accepted(DeviceState{.p_WP = bad_vector}));
      EXPECT_FALSE(is_accepted(ForceCommand{.force_n = bad_vector}));
      EXPECT_FALSE(is_accepted(ForceCommand{.visual_offset_m = bad_vector}));
      EXPECT_FALSE(is_accepted(ForceCommand{.torque_nm = bad_vector}));
      EXPECT_FALSE(is_accepted(ForceCommand{.visual_turn = bad_vector}));
      EXPECT_FALSE(is_accepted(ForceCommand{.push = ObjectPush{.force_n = bad_vector}}));
      EXPECT_FALSE(is_accepted(ForceCommand{.push = ObjectPush{.torque_nm = bad_vector}}));
    }
  }
  EXPECT_FALSE(is_accepted(DeviceState{.q_WT = Quat(1.002, 0, 0, 0)}));
  EXPECT_TRUE(is_accepted(DeviceState{.q_WT = Quat(1.0009, 0, 0, 0)}));
}

TEST_F(FixedCodec, NeedsNoHeapAndFitsOrWritesNothing) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "this build cannot count allocations";
  const Datagram sent = random_.draw(kForceCommand);
  const Bytes whole = write(sent);
  std::array<std::byte, kMaxDatagramBytes> bytes;
  Datagram read;
  const AllocationGuard guard;
  for (std::size_t room = 0; room < whole.size(); ++room) EXPECT_EQ(encode_round_trip(sent, std::span(bytes).first(room)), 0U);
  EXPECT_EQ(encode_round_trip(sent, std::span(bytes).first(whole.size())), whole.size());
  EXPECT_TRUE(decode_round_trip(std::span(bytes).first(whole.size()), read));
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
