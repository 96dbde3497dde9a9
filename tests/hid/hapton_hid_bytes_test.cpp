// The bytes of the tables in docs/hid.md that the C code for the maker's side does not read.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "hid/hapton_hid_reports.h"

namespace hapton::hapton_hid {
namespace {

std::vector<std::uint8_t> names_report(const std::string& model, const std::string& serial, const std::string& firmware) {
  std::vector<std::uint8_t> report(kNamesBytes);
  report[0] = kNamesId;
  std::copy(model.begin(), model.end(), report.begin() + 2);
  std::copy(serial.begin(), serial.end(), report.begin() + 26);
  std::copy(firmware.begin(), firmware.end(), report.begin() + 42);
  return report;
}

TEST(HaptonHidBytes, AForceNamesItselfAndTheNewestState) {
  const auto report = encode_force({.is_on = true, .sequence = 0x1234, .newest_state = 0xABCD, .force_n = Vec3(1e-6, 0, 0)});
  EXPECT_EQ(std::vector<int>(report.begin(), report.begin() + 12), (std::vector<int>{2, 1, 0x34, 0x12, 0xCD, 0xAB, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(encode_force({.is_on = false})[1], 0);
}

TEST(HaptonHidBytes, EachNameMayFillItsField) {
  const auto names = decode_names(names_report("a model of 24 characters", "a serial of 16 c", "a version of 16."));
  ASSERT_TRUE(names);
  EXPECT_EQ(names->model, "a model of 24 characters");
  EXPECT_EQ(names->serial, "a serial of 16 c");
  EXPECT_EQ(names->firmware, "a version of 16.");
}

TEST(HaptonHidBytes, AFeatureReportOfAnotherNumberIsRejected) {
  std::vector<std::uint8_t> report = names_report("m", "s", "f");
  ASSERT_TRUE(decode_names(report));
  report[0] = kLimitsId;
  EXPECT_FALSE(decode_names(report));
  // Limits that are all valid; only the number of the report is changed below.
  std::vector<std::uint8_t> limits(kLimitsBytes);
  limits[0] = kLimitsId;
  limits[1] = kVersion;
  std::copy_n("HAPT", 4, limits.begin() + 4);
  limits[9] = 4;                                                           // 1024 Hz
  limits[10] = 20;                                                         // ms
  for (const std::size_t at : {26U, 30U, 34U, 38U, 46U}) limits[at] = 16;  // about 0.1 m each, 1 N, 1049 N/s
  ASSERT_TRUE(decode_limits(limits)) << decode_limits(limits).error().what;
  limits[0] = kNamesId;
  EXPECT_FALSE(decode_limits(limits));
}

}  // namespace
}  // namespace hapton::hapton_hid
