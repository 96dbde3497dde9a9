#include "io_node/vrpn/vrpn_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <string>

#include "tests/vrpn/hex.h"

namespace hapton::vrpn {
namespace {

using ::testing::ElementsAre;

constexpr Time kNow = {1, 2};

// Messages of a client, with its own numbers for senders and types.
struct ClientMessages {
  Bytes bytes;

  ClientMessages() { append_cookie(bytes); }
  void describe_sender(std::int32_t id, std::string_view name) { append_description(bytes, kSenderDescription, id, name, kNow, 0); }
  void describe_type(std::int32_t id, std::string_view name) { append_description(bytes, kTypeDescription, id, name, kNow, 0); }
  void say(std::int32_t sender, std::int32_t type) { append_empty(bytes, {sender, type, kNow, 0}); }
};

// Types and senders of all messages in these bytes, as "type/sender".
std::vector<std::string> messages_in(std::span<const std::byte> bytes) {
  std::vector<std::string> listed;
  Message message;
  while (read_message(bytes, message) == ReadStatus::message) {
    listed.push_back(std::to_string(message.type) + "/" + std::to_string(message.sender));
  }
  return listed;
}

Bytes take_output(Client& client) { return std::exchange(client.out(), {}); }

TEST(VrpnClient, IsGreetedWithTheCookieAlone) {
  Client client("Phantom0");
  Bytes cookie;
  append_cookie(cookie);
  EXPECT_EQ(client.out(), cookie);
  EXPECT_FALSE(client.is_connected());
}

TEST(VrpnClient, GetsOurNamesAfterItsCookie) {
  Client client("Phantom0");
  take_output(client);
  ASSERT_TRUE(client.receive(ClientMessages().bytes, kNow));
  EXPECT_TRUE(client.is_connected());
  EXPECT_THAT(messages_in(client.out()), ElementsAre("-1/0", "-2/0", "-2/1", "-2/2", "-2/3", "-2/4", "-2/5", "-2/6", "-2/7", "-2/8", "-2/9",
                                                     "-2/10", "-2/11", "-2/12"));
  std::span<const std::byte> rest(client.out());
  Message message;
  read_message(rest, message);
  EXPECT_EQ(name_of(message), "Phantom0");
}

TEST(VrpnClient, IsNotifiedOfRejectedForcesOnceASecond) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.describe_sender(3, "Phantom0");
  messages.describe_type(4, "vrpn_ForceDevice Plane2");
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  take_output(client);
  messages.bytes.clear();
  for (int n = 0; n < 1000; ++n) messages.say(3, 4);
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  EXPECT_EQ(client.rejected_forces(), 1000U);
  const Bytes text_message = take_output(client);
  std::span<const std::byte> rest(text_message);
  Message message;
  ASSERT_EQ(read_message(rest, message), ReadStatus::message);
  EXPECT_TRUE(rest.empty());
  EXPECT_EQ(message.type, static_cast<std::int32_t>(OurType::text));
  ASSERT_EQ(message.body.size(), 8U + 1024U) << "the fixed length of a text message";
  EXPECT_EQ(to_hex(Bytes(message.body.begin(), message.body.begin() + 8)), to_hex(hex("00000002 00000000"))) << "an error, level 0";
  EXPECT_NE(std::string(reinterpret_cast<const char*>(message.body.data()) + 8).find("only the haptics node sends forces"),
            std::string::npos);
  ASSERT_TRUE(client.receive(messages.bytes, {kNow.s + 1, 0}));
  EXPECT_EQ(messages_in(take_output(client)).size(), 1U);
}

TEST(VrpnClient, GetsTheTransformsItAsksFor) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.describe_sender(3, "Phantom0");
  messages.describe_type(4, "vrpn_Tracker Request_Tracker_To_Room");
  messages.describe_type(5, "vrpn_Tracker Request_Unit_To_Sensor");
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  take_output(client);
  messages.bytes.clear();
  messages.say(3, 4);
  messages.say(3, 5);
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  const Bytes replies = take_output(client);
  EXPECT_THAT(messages_in(replies), ElementsAre("9/0", "10/0", "10/0"));
  std::span<const std::byte> rest(replies);
  const std::string identity =
      to_hex(hex("0000000000000000 0000000000000000 0000000000000000"
                 "0000000000000000 0000000000000000 0000000000000000 3ff0000000000000"));
  for (const char* begin : {"", "00000000 00000000", "00000001 00000000"}) {
    Message message;
    ASSERT_EQ(read_message(rest, message), ReadStatus::message);
    EXPECT_EQ(to_hex(Bytes(message.body.begin(), message.body.end())), to_hex(hex(begin)) + identity);
  }
}

TEST(VrpnClient, SetsItsRateOfReports) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.describe_sender(3, "Phantom0");
  messages.describe_type(4, "vrpn_Tracker set_update_rate");
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  EXPECT_FALSE(client.wanted_rate_hz());
  const auto request_rate = [&](double rate_hz) {
    Bytes bytes;
    append_analog(bytes, {3, 4, kNow, 0}, {});  // its body is one 64-bit number, a count, which the rate replaces below
    const auto bits = std::bit_cast<std::uint64_t>(rate_hz);
    for (std::size_t i = 0; i < 8; ++i) bytes[kHeaderBytes + i] = static_cast<std::byte>(bits >> (56 - 8 * i));
    EXPECT_TRUE(client.receive(bytes, kNow));
  };
  request_rate(60.0);
  EXPECT_EQ(client.wanted_rate_hz(), 60.0);
  for (const double bad : {0.0, -5.0, std::numeric_limits<double>::quiet_NaN()}) {
    request_rate(bad);
    EXPECT_EQ(client.wanted_rate_hz(), 60.0);
  }
  ClientMessages without_body;
  without_body.bytes.clear();
  without_body.say(3, 4);  // its body is empty
  EXPECT_TRUE(client.receive(without_body.bytes, kNow));
  EXPECT_EQ(client.wanted_rate_hz(), 60.0);
}

TEST(VrpnClient, MaySendAByteAtATime) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.describe_sender(4, "Phantom0");
  messages.describe_type(17, "vrpn_Base ping_message");
  messages.say(4, 17);
  for (const std::byte byte : messages.bytes) ASSERT_TRUE(client.receive({&byte, 1}, kNow));
  EXPECT_TRUE(client.is_connected());
}

TEST(VrpnClient, WithAnotherCookieIsRejected) {
  Client client("Phantom0");
  const std::string request = "GET / HTTP/1.1\r\nHost: localhost\r\n";
  EXPECT_FALSE(client.receive(std::as_bytes(std::span(request)), kNow));
}

TEST(VrpnClient, RepliesToAPingThatIsForUs) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.describe_sender(4, "Phantom0");
  messages.describe_sender(5, "Tracker0");
  messages.describe_type(17, "vrpn_Base ping_message");
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  take_output(client);
  messages.bytes.clear();
  messages.say(5, 17);
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  EXPECT_TRUE(client.out().empty()) << "a client that looks for another device must not find it here";
  messages.bytes.clear();
  messages.say(4, 17);
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  EXPECT_THAT(messages_in(client.out()), ElementsAre("0/0"));
}

TEST(VrpnClient, MayGiveANumberAnotherMeaning) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.describe_sender(4, "Phantom0");
  messages.describe_sender(4, "Tracker0");
  messages.describe_type(17, "vrpn_Base ping_message");
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  take_output(client);
  messages.bytes.clear();
  messages.say(4, 17);
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  EXPECT_TRUE(client.out().empty());
}

TEST(VrpnClient, ThatRequestsUdpSendsItsPortInTheSendersPlace) {
  Client client("Phantom0");
  ClientMessages messages;
  // The text "127.0.0.1" with a zero byte at its end, for port 0xd431.
  const Bytes request = hex("00000022 00000000 00000000 0000d431 fffffffd 00000000 3132372e302e302e31 00 000000000000");
  messages.bytes.insert(messages.bytes.end(), request.begin(), request.end());
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  ASSERT_TRUE(client.udp_request());
  EXPECT_EQ(client.udp_request()->address, "127.0.0.1");
  EXPECT_EQ(client.udp_request()->port, 0xd431);
}

TEST(VrpnClient, ThatRequestsAnImpossiblePortIsNotFollowed) {
  for (const char* port : {"00000000", "00010000", "ffffffff"}) {
    Client client("Phantom0");
    ClientMessages messages;
    const Bytes request = hex("00000022 00000000 00000000" + std::string(port) + "fffffffd 00000000 3132372e302e302e31 00 000000000000");
    messages.bytes.insert(messages.bytes.end(), request.begin(), request.end());
    ASSERT_TRUE(client.receive(messages.bytes, kNow));
    EXPECT_FALSE(client.udp_request()) << port;
  }
}

TEST(VrpnClient, ThatRequestsForcesIsRejectedAndCounted) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.describe_sender(4, "Phantom0");
  messages.describe_type(20, "vrpn_ForceDevice Plane");
  messages.describe_type(21, "vrpn_ForceDevice Force_Field");
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  EXPECT_EQ(client.rejected_forces(), 0U) << "a description of a type requests nothing";
  take_output(client);
  messages.bytes.clear();
  messages.say(4, 20);
  messages.say(4, 21);
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  EXPECT_EQ(client.rejected_forces(), 2U);
  EXPECT_EQ(messages_in(client.out()).size(), 1U) << "one text for both";
}

TEST(VrpnClient, MayAskForTheWorkspace) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.describe_sender(4, "Phantom0");
  messages.describe_type(30, "vrpn_Tracker Request_Tracker_Workspace");
  messages.say(4, 30);
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  EXPECT_TRUE(client.take_workspace_request());
  EXPECT_FALSE(client.take_workspace_request());
}

TEST(VrpnClient, ThatSaysGoodbyeIsDropped) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.say(0, kDisconnect);
  EXPECT_FALSE(client.receive(messages.bytes, kNow));
}

TEST(VrpnClient, WithAnImpossibleMessageIsDropped) {
  Client client("Phantom0");
  ClientMessages messages;
  messages.bytes.resize(messages.bytes.size() + kHeaderBytes, std::byte{0xff});
  EXPECT_FALSE(client.receive(messages.bytes, kNow));
}

TEST(VrpnClient, WithEndlessNamesTakesBoundedMemory) {
  Client client("Phantom0");
  ClientMessages messages;
  for (std::int32_t id = 0; id < 100'000; ++id) messages.describe_type(id, "vrpn_ForceDevice Plane");
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  take_output(client);
  messages.bytes.clear();
  messages.describe_sender(1, "Phantom0");
  messages.say(1, 99'999);
  ASSERT_TRUE(client.receive(messages.bytes, kNow));
  EXPECT_EQ(client.rejected_forces(), 0U) << "the client keeps no more types";
}

TEST(VrpnClient, SequenceNumbersCountTheMessages) {
  Client client("Phantom0");
  const std::uint32_t first = client.header(OurType::position, kNow).sequence;
  EXPECT_EQ(client.header(OurType::position, kNow).sequence, first + 1);
}

}  // namespace
}  // namespace hapton::vrpn
