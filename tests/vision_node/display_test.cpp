#include "vision_node/display.h"

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(Display, SaysWhatIsMissingAndHowToFixIt) {
  const std::string real = std::getenv("DISPLAY");
  for (const char* wrong : {"", ":9876"}) {
    setenv("DISPLAY", wrong, 1);
    const auto display = DisplayConnection::open();
    ASSERT_FALSE(display) << wrong;
    EXPECT_NE(display.error().what.find("xvfb-run"), std::string::npos);
    EXPECT_EQ(display.error().what.find('\n'), std::string::npos);
  }
  unsetenv("DISPLAY");
  EXPECT_FALSE(DisplayConnection::open());
  setenv("DISPLAY", real.c_str(), 1);
  EXPECT_TRUE(DisplayConnection::open());
}

}  // namespace
}  // namespace hapton
