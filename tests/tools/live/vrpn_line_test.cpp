#include "tools/live/vrpn_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/support/one_line.h"
#include "tests/vrpn/made_tracker.h"

namespace hapton {
namespace {

TEST(VrpnLines, AreAServerAndAButton) {
  const auto input = parse_line_input("vrpn:Pedal@host:3884:7");
  ASSERT_TRUE(input) << input.error().what;
  EXPECT_TRUE(input->is_vrpn);
  EXPECT_EQ(input->device, "Pedal@host:3884");
  EXPECT_EQ(input->name, "button 7");
  EXPECT_EQ(input->bit, 7);
  for (const char* bad : {"vrpn:", "vrpn:Pedal@host", "vrpn:Pedal@host:", "vrpn:Pedal@host:32", "vrpn:Pedal@host:-1", "vrpn:Pedal@host:1x",
                          "vrpn:Pedal:0", "vrpn:@host:0"}) {
    EXPECT_FALSE(parse_line_input(bad)) << bad;
  }
}

TEST(VrpnLines, WithoutAServerAreOneLine) {
  const auto line = open_line_input(*parse_line_input("vrpn:Pedal@127.0.0.1:1:0"));
  ASSERT_FALSE(line);
  EXPECT_NE(line.error().what.find("no VRPN server replies at 127.0.0.1:1"), std::string::npos) << line.error().what;
  EXPECT_THAT(line.error().what, IsOneLine());
}

TEST(VrpnLines, FollowTheButtonOfTheServer) {
  constexpr std::int32_t kChange = 11;
  vrpn::MadeTracker server;
  vrpn::Bytes hello = vrpn::say_hello("Pedal");
  vrpn::append_description(hello, vrpn::kTypeDescription, kChange, "vrpn_Button Change", {}, 3);
  server.set_hello(hello);
  std::atomic<bool> is_opened{false};
  const auto input = parse_line_input("vrpn:Pedal@" + to_string(server.address()) + ":2");
  ASSERT_TRUE(input) << input.error().what;
  Result<std::unique_ptr<DigitalLine>> line = fail("not yet");
  std::thread opener([&] {
    line = open_line_input(*input);
    is_opened = true;
  });
  EXPECT_TRUE(server.attend_until([&](std::int64_t) { return is_opened.load(); }));
  opener.join();
  ASSERT_TRUE(line) << line.error().what;
  for (const bool is_down : {true, false, true}) {
    vrpn::Bytes bytes;
    vrpn::append_button_change(bytes, {vrpn::kMadeSender, kChange, {}, 4}, 2, is_down);
    vrpn::append_button_change(bytes, {vrpn::kMadeSender, kChange, {}, 5}, 1, !is_down);
    server.say(bytes);
    EXPECT_TRUE(server.attend_until([&](std::int64_t) { return *(*line)->is_on() == is_down; })) << is_down;
  }
  // The button is held while the connection is lost, and released later.
  const int calls_before = server.calls();
  const std::size_t bytes_before = server.heard().size();
  server.hang_up();
  EXPECT_TRUE(server.attend_until([&](std::int64_t) {
    EXPECT_TRUE(*(*line)->is_on());
    return server.calls() > calls_before && server.heard().size() > bytes_before + vrpn::kCookieBytes;  // it has read the first messages
  }));
  EXPECT_TRUE(*(*line)->is_on()) << "until the server reports the button";
  vrpn::Bytes release;
  vrpn::append_button_change(release, {vrpn::kMadeSender, kChange, {}, 4}, 2, false);
  server.say(release);
  EXPECT_TRUE(server.attend_until([&](std::int64_t) { return !*(*line)->is_on(); }));
}

}  // namespace
}  // namespace hapton
