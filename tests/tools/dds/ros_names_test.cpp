#include "tools/dds/ros_names.h"

#include <gtest/gtest.h>

#include <string>

namespace hapton::dds {
namespace {

TEST(RosNames, APrefixBeginsWithASlash) {
  EXPECT_EQ(*make_prefix("hapton"), "/hapton");
  EXPECT_EQ(*make_prefix("/arm_1/Pen2"), "/arm_1/Pen2");
  EXPECT_EQ(*make_prefix("_a"), "/_a");
  for (const char* bad : {"", "/", "//", "a/", "/a//b", "1a", "a/2", "a__b", "a b", "a.b", "\n"}) {
    const auto made = make_prefix(bad);
    ASSERT_FALSE(made) << bad;
    EXPECT_EQ(made.error().what.find('\n'), std::string::npos);
  }
  EXPECT_TRUE(make_prefix(std::string(200, 'a')));
  EXPECT_FALSE(make_prefix(std::string(201, 'a')));
}

TEST(RosNames, ATopicOfRosHasThePrefixRt) { EXPECT_EQ(dds_topic("/hapton/measured_cf"), "rt/hapton/measured_cf"); }

TEST(RosNames, TheDomainIsTheOneGivenOrThatOfRos) {
  EXPECT_EQ(*choose_domain(7, "9"), 7);
  EXPECT_EQ(*choose_domain(std::nullopt, "9"), 9);
  EXPECT_EQ(*choose_domain(std::nullopt, ""), 0);
  EXPECT_EQ(*choose_domain(std::nullopt, nullptr), 0);
  EXPECT_EQ(*choose_domain(kHighestDomain, nullptr), kHighestDomain);
  EXPECT_FALSE(choose_domain(kHighestDomain + 1, nullptr));
  EXPECT_FALSE(choose_domain(-1, nullptr));
  EXPECT_FALSE(choose_domain(std::nullopt, "9 "));
}

TEST(RosNames, FramesAndInterfacesAreNamesWithoutBlanks) {
  EXPECT_TRUE(check_frame("map"));
  EXPECT_TRUE(check_frame("robot/base-link"));
  EXPECT_FALSE(check_frame("/map"));
  EXPECT_FALSE(check_frame(""));
  EXPECT_FALSE(check_frame("base link"));
  EXPECT_TRUE(check_frame(std::string(200, 'a')));
  EXPECT_FALSE(check_frame(std::string(201, 'a')));
  EXPECT_TRUE(check_interface("eth0"));
  EXPECT_TRUE(check_interface("192.168.1.5"));
  EXPECT_TRUE(check_interface("enp0s31f6.100"));
  EXPECT_FALSE(check_interface("<x>"));
  EXPECT_FALSE(check_interface(""));
  EXPECT_FALSE(check_interface("eth 0"));
}

}  // namespace
}  // namespace hapton::dds
