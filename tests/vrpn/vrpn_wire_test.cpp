// Compares messages byte for byte with ones that were composed by hand from the protocol.
#include "vrpn/vrpn_wire.h"

#include <gtest/gtest.h>

#include <bit>
#include <optional>
#include <utility>

#include "tests/vrpn/hex.h"

namespace hapton::vrpn {
namespace {

// A message is: length, seconds, microseconds, sender, type, sequence; then the body. kHeaderRest: the header without the length.
constexpr Header kHeader = {.sender = 2, .type = 5, .time = {0x01020304, 0x000f4240 - 1}, .sequence = 9};
constexpr std::string_view kHeaderRest = "01020304 000f423f 00000002 00000005 00000009 ";
constexpr std::string_view kOne = "3ff0000000000000 ", kMinusTwo = "c000000000000000 ", kHalf = "3fe0000000000000 ",
                           kZero = "0000000000000000 ";

std::string join(std::initializer_list<std::string_view> parts) {
  std::string all;
  for (const std::string_view part : parts) all += part;
  return all;
}

void expect_bytes(const Bytes& bytes, std::initializer_list<std::string_view> expected) {
  EXPECT_EQ(to_hex(bytes), to_hex(hex(join(expected))));
}

TEST(VrpnWire, Cookie) {
  Bytes out;
  append_cookie(out);
  // "vrpn: ver. 07.38", two spaces, the log mode 0, then zeros.
  expect_bytes(out, {"76 72 70 6e 3a 20 76 65 72 2e 20 30 37 2e 33 38 20 20 30 00 00 00 00 00"});
}

TEST(VrpnWire, CookiesAreDistinguishedByTheirMajorVersion) {
  const auto is_good = [](std::string_view cookie) {
    Bytes bytes(kCookieBytes);
    for (std::size_t n = 0; n < cookie.size(); ++n) bytes[n] = static_cast<std::byte>(cookie[n]);
    return is_cookie_good(bytes);
  };
  EXPECT_TRUE(is_good("vrpn: ver. 07.38  0"));
  EXPECT_TRUE(is_good("vrpn: ver. 07.33  3"));
  EXPECT_FALSE(is_good("vrpn: ver. 06.38  0"));
  EXPECT_FALSE(is_good("GET / HTTP/1.1"));
  EXPECT_FALSE(is_good(""));
}

TEST(VrpnWire, SenderDescription) {
  Bytes out;
  append_description(out, kSenderDescription, 3, "Phantom0", {0x01020304, 7}, 1);
  // Header 24 + length 4 + name 9 = 37 = 0x25, padded to 40. The number of the described sender is in the sender field.
  expect_bytes(out, {"00000025 01020304 00000007 00000003 ffffffff 00000001 ", "00000009 5068616e746f6d30 00 000000"});
}

TEST(VrpnWire, TypeDescription) {
  Bytes out;
  append_description(out, kTypeDescription, 1, "vrpn_Button Change", {}, 2);
  expect_bytes(out, {"0000002f 00000000 00000000 00000001 fffffffe 00000002 ", "00000013 7672706e5f427574746f6e204368616e6765 00 00"});
}

TEST(VrpnWire, TrackerPositionAndQuaternionInTheOrderXYZW) {
  Bytes out;
  append_position(out, kHeader, 0, {1, -2, 0.5}, Quat(/*w*/ 1, /*x*/ 0.5, /*y*/ 0, /*z*/ -2));
  expect_bytes(out, {"00000058 ", kHeaderRest, "00000000 00000000 ", kOne, kMinusTwo, kHalf, kHalf, kZero, kMinusTwo, kOne});
}

TEST(VrpnWire, TrackerVelocity) {
  Bytes out;
  append_velocity(out, kHeader, {1, -2, 0.5}, Quat::Identity(), 0.5);
  expect_bytes(out, {"00000060 ", kHeaderRest, "00000000 00000000 ", kOne, kMinusTwo, kHalf, kZero, kZero, kZero, kOne, kHalf});
}

TEST(VrpnWire, TrackerWorkspace) {
  Bytes out;
  append_workspace(out, kHeader, {-2, -2, -2}, {1, 1, 0.5});
  expect_bytes(out, {"00000048 ", kHeaderRest, kMinusTwo, kMinusTwo, kMinusTwo, kOne, kOne, kHalf});
}

TEST(VrpnWire, ButtonChangeIsTwoNumbersWithoutACount) {
  Bytes out;
  append_button_change(out, kHeader, 3, true);
  expect_bytes(out, {"00000020 ", kHeaderRest, "00000003 00000001"});
}

TEST(VrpnWire, ButtonStates) {
  Bytes out;
  append_button_states(out, kHeader, 0b101, 3);
  expect_bytes(out, {"00000028 ", kHeaderRest, "00000003 00000001 00000000 00000001"});
}

TEST(VrpnWire, AnalogChannelsWithTheirCountAsADouble) {
  Bytes out;
  const std::array<double, 2> channels = {1.0, -2.0};
  append_analog(out, kHeader, channels);
  expect_bytes(out, {"00000030 ", kHeaderRest, "4000000000000000 ", kOne, kMinusTwo});
}

TEST(VrpnWire, Force) {
  Bytes out;
  append_force(out, kHeader, {1, -2, 0.5});
  expect_bytes(out, {"00000030 ", kHeaderRest, kOne, kMinusTwo, kHalf});
}

TEST(VrpnWire, ForceErrorIsPaddedButItsLengthIsNot) {
  Bytes out;
  append_force_error(out, kHeader, 3);
  expect_bytes(out, {"0000001c ", kHeaderRest, "00000003 00000000"});
}

TEST(VrpnWire, PongIsAHeaderAlone) {
  Bytes out;
  append_empty(out, kHeader);
  expect_bytes(out, {"00000018 ", kHeaderRest});
}

TEST(VrpnWire, MessagesFollowEachOther) {
  Bytes out;
  append_force_error(out, kHeader, 3);
  append_empty(out, kHeader);
  EXPECT_EQ(out.size(), 32U + 24U);
}

TEST(VrpnWire, AMessageIsReadWithItsPadding) {
  const Bytes bytes = hex("0000001c 00000000 00000000 00000002 00000005 00000000 0000002a 00000000 00000018");
  std::span<const std::byte> rest(bytes);
  Message message;
  ASSERT_EQ(read_message(rest, message), ReadStatus::message);
  EXPECT_EQ(message.sender, 2);
  EXPECT_EQ(message.type, 5);
  EXPECT_EQ(to_hex(message.body), "00 00 00 2a ");
  EXPECT_EQ(rest.size(), 4U);
  EXPECT_EQ(read_message(rest, message), ReadStatus::incomplete);
}

TEST(VrpnWire, ImpossibleLengthsAreRejected) {
  Message message;
  for (const char* length : {"00000000", "00000017", "ffffffff", "80000000", "00004001"}) {
    const Bytes bytes = hex(join({length, "00000000 00000000 00000000 00000000 00000000"}));
    std::span<const std::byte> rest(bytes);
    EXPECT_EQ(read_message(rest, message), ReadStatus::broken) << length;
  }
}

TEST(VrpnWire, NamesAreTakenByTheirLengthAndZero) {
  const auto name = [](std::string_view body) {
    const Bytes bytes = hex(body);
    return std::string(name_of({0, kSenderDescription, bytes}));
  };
  EXPECT_EQ(name("00000003 6162 00"), "ab");
  EXPECT_EQ(name("00000003 6162 63"), "") << "no zero";
  EXPECT_EQ(name("00000004 6162 00"), "") << "longer than the body";
  EXPECT_EQ(name("ffffffff 6162 00"), "");
  EXPECT_EQ(name("00000000 6162 00"), "");
  EXPECT_EQ(name("0000"), "");
}

// A name has at most 100 bytes, its terminating zero included.
TEST(VrpnWire, ANameThatIsTooLongIsReadAsEmpty) {
  for (const std::size_t letters : {std::size_t{99}, std::size_t{100}}) {
    Bytes out;
    append_description(out, kSenderDescription, 1, std::string(letters, 'x'), {}, 1);
    std::span<const std::byte> rest(out);
    Message message;
    ASSERT_EQ(read_message(rest, message, 4096), ReadStatus::message);
    EXPECT_EQ(name_of(message).size(), letters == 99 ? 99U : 0U);
  }
}

TEST(VrpnWire, ANumberIsABodyOfEightBytes) {
  for (const auto& [body, number] : {std::pair<std::string_view, std::optional<double>>{kMinusTwo, -2.0},
                                     {"3ff80000 00000001", std::bit_cast<double>(std::uint64_t{0x3ff8000000000001})},
                                     {"3ff00000", std::nullopt},
                                     {"3ff00000 00000000 00", std::nullopt}}) {
    const Bytes bytes = hex(body);
    EXPECT_EQ(number_of({1, 2, bytes}), number) << body;
  }
}

TEST(VrpnWire, StatesOfButtonsAreACountAndAWordForEach) {
  const auto buttons = [](std::string_view body) {
    const Bytes bytes = hex(body);
    return buttons_of({1, 2, bytes});
  };
  EXPECT_EQ(buttons("00000003 00000000 00000001 00000002"), 0b110U);
  EXPECT_EQ(buttons("00000000"), 0U);
  EXPECT_EQ(buttons("00000001"), std::nullopt);
  EXPECT_EQ(buttons("00000001 00000001 00000001"), std::nullopt);
  EXPECT_EQ(buttons("0000"), std::nullopt);
  std::string many = "00000021 ";
  for (int n = 0; n < 33; ++n) many += n == 0 ? "00000000" : "00000001";
  EXPECT_EQ(buttons(many), 0xfffffffeU) << "a button beyond the 32nd has no bit";
}

TEST(VrpnWire, APoseIsReadWhereItIsWritten) {
  Bytes out;
  append_position(out, kHeader, 7, {1.5, -2.25, 1e-3}, Quat(0.1, 0.2, 0.3, 0.4));
  std::span<const std::byte> rest(out);
  Message message;
  ASSERT_EQ(read_message(rest, message), ReadStatus::message);
  EXPECT_TRUE(rest.empty());
  const auto pose = position_of(message);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->sensor, 7);
  EXPECT_EQ(pose->p_m, Vec3(1.5, -2.25, 1e-3));
  EXPECT_EQ(pose->q.coeffs(), Quat(0.1, 0.2, 0.3, 0.4).coeffs());
}

}  // namespace
}  // namespace hapton::vrpn
