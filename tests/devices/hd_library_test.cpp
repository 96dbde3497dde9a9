#include "devices/hd_library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace hapton::hd {
namespace {

using ::testing::HasSubstr;

int errors_read = 0;
int errors_left = 0;

Library library_with_errors(int count) {
  errors_read = 0;
  errors_left = count;
  Library hd;
  hd.get_error = [] {
    ++errors_read;
    return ErrorInfo{errors_left-- > 0 ? kCommError : kSuccess, 0, 0};
  };
  return hd;
}

// Because of a force error the force is released for a moment; because of a device error the device is opened again.
TEST(HdLibrary, ForceErrorsAreNotDeviceErrors) {
  for (const Enum code : {0x200U, 0x204U, 0x2FFU}) EXPECT_TRUE(is_force_error(code) && !is_device_error(code)) << code;
  for (const Enum code : {0x300U, 0x302U, 0x3FFU, 0x104U}) EXPECT_TRUE(is_device_error(code) && !is_force_error(code)) << code;
  for (const Enum code : {0U, 0x100U, 0x103U, 0x105U, 0x1FFU, 0x400U, 0x600U, 0x1200U, 0x1300U}) {
    EXPECT_FALSE(is_force_error(code) || is_device_error(code)) << code;
  }
}

TEST(HdLibrary, AnErrorHasANameANumberAndARemedyWhereOneIsKnown) {
  EXPECT_EQ(name_of_error(0x104), "HD_BAD_HANDLE (0x104)");
  EXPECT_EQ(name_of_error(0x999), "error 0x999");
  EXPECT_EQ(name_of_error(0x9), "error 0x009");
  EXPECT_THAT(std::string(remedy_for_error(0x303)), HasSubstr("Touch_Setup"));
  EXPECT_THAT(std::string(remedy_for_error(0x202)), HasSubstr("--max-slew"));
  EXPECT_THAT(std::string(remedy_for_error(0x203)), HasSubstr("more slowly"));
  EXPECT_EQ(remedy_for_error(0x100), "");
  EXPECT_EQ(remedy_for_error(0x999), "");
}

TEST(HdLibrary, OldErrorsAreForgottenAndEndlessOnesDoNotBlock) {
  forget_errors(library_with_errors(3));
  EXPECT_EQ(errors_read, 4) << "up to the first success";
  forget_errors(library_with_errors(1'000'000));
  EXPECT_EQ(errors_read, 64);
}

}  // namespace
}  // namespace hapton::hd
