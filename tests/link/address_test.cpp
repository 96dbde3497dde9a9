#include "link/address.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

using ::testing::HasSubstr;

TEST(ParseAddress, ReadsWhatItWrites) {
  for (const char* text : {"127.0.0.1:4950", "255.255.255.255:65535", "0.0.0.0:0", "[::1]:4950", "[2001:db8::7]:1"}) {
    const Result<Address> address = parse_address(text);
    ASSERT_TRUE(address) << address.error().what;
    EXPECT_EQ(to_string(*address), text);
  }
}

TEST(ParseAddress, FillsInTheHubsPort) {
  EXPECT_EQ(to_string(*parse_address("10.1.2.3")), "10.1.2.3:4950");
  EXPECT_EQ(to_string(*parse_address("::1")), "[::1]:4950");
  EXPECT_EQ(to_string(*parse_address("[::1]")), "[::1]:4950");
  EXPECT_EQ(to_string(*parse_address("10.1.2.3", 0)), "10.1.2.3:0");
}

TEST(ParseAddress, ResolvesNames) {
  const Result<Address> address = parse_address("localhost:77");
  ASSERT_TRUE(address) << address.error().what;
  EXPECT_EQ(to_string(*address), "127.0.0.1:77");
}

TEST(ParseAddress, SaysWhatIsWrongInOneLine) {
  for (const char* text : {"", ":5", "1.2.3.4:", "1.2.3.4:x", "1.2.3.4:65536", "1.2.3.4:-1", "[::1", "[::1]5", "no such host:1",
                           "fe80::1%eth0", "1.2.3.4:80:90", "4950", "0"}) {
    const Result<Address> address = parse_address(text);
    ASSERT_FALSE(address) << text;
    EXPECT_THAT(address.error().what, HasSubstr(fmt::format("address '{}'", text)));
    EXPECT_EQ(address.error().what.find('\n'), std::string::npos);
  }
}

// As an IPv4 address, "4950" would be 0.0.19.86.
TEST(ParseAddress, RejectsANumberAloneAndSaysHowToWriteAPort) {
  const Result<Address> address = parse_address("3883");
  ASSERT_FALSE(address);
  EXPECT_THAT(address.error().what, HasSubstr("127.0.0.1:3883"));
}

TEST(Address, KnowsItsFamilyAndWhetherItIsLoopback) {
  struct Case {
    const char* text;
    bool is_v4, is_loopback;
  };
  for (const Case& c : {Case{"127.0.0.1:1", true, true}, Case{"127.9.9.9:1", true, true}, Case{"0.0.0.0:1", true, false},
                        Case{"128.0.0.1:1", true, false}, Case{"[::1]:1", false, true}, Case{"[::]:1", false, false},
                        Case{"[::2]:1", false, false}, Case{"[::fffe:7f00:1]:1", false, false}}) {
    const auto address = parse_address(c.text);
    ASSERT_TRUE(address) << c.text;
    EXPECT_EQ(is_v4(*address), c.is_v4) << c.text;
    EXPECT_EQ(is_loopback(*address), c.is_loopback) << c.text;
    EXPECT_EQ(any_address_like(*address), c.is_v4 ? "0.0.0.0:0" : "[::]:0");
  }
}

}  // namespace
}  // namespace hapton
