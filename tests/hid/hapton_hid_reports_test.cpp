#include "hid/hapton_hid_reports.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <regex>
#include <sstream>
#include <utility>

#include "docs/hid/hapton_hid_device.h"

namespace hapton::hapton_hid {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

hapton_hid_limits maker_limits() {
  hapton_hid_limits limits = {};
  limits.has_orientation = true;
  limits.knows_held = true;
  limits.has_torque = true;
  limits.buttons = 2;
  limits.rate_hz = 1000;
  limits.watchdog_ms = 20;
  for (int n = 0; n < 3; ++n) {
    limits.workspace_min_m[n] = -0.1f * static_cast<float>(n + 1);
    limits.workspace_max_m[n] = 0.11f * static_cast<float>(n + 1);
  }
  limits.max_force_n = 7.5f;
  limits.continuous_force_n = 2.25f;
  limits.max_slew_n_per_s = 2000.0f;
  limits.max_stiffness_n_per_m = 1500.0f;
  limits.max_torque_nm = 0.125f;
  limits.max_torque_slew_nm_per_s = 50.0f;
  limits.peak_s = 4.5f;
  limits.max_speed_m_per_s = 3.0f;
  limits.model = "Test arm";
  limits.serial = "SN-0042";
  limits.firmware = "1.2.3";
  return limits;
}

Bytes feature(std::uint8_t id, const hapton_hid_limits& limits = maker_limits()) {
  hapton_hid_device device;
  hapton_hid_init(&device, &limits);
  Bytes report(64);
  report.resize(hapton_hid_feature(&device, id, report.data(), report.size()));
  return report;
}

std::string rejection(const hapton_hid_limits& limits) {
  const auto decoded = decode_limits(feature(kLimitsId, limits));
  return decoded ? "accepted" : decoded.error().what;
}

hapton_hid_measured measured_at_rest() {
  hapton_hid_measured measured = {};
  measured.is_calibrated = true;
  measured.orientation[3] = 1.0f;
  return measured;
}

TEST(HaptonHidReports, LimitsAreWhatTheMakerSaid) {
  const auto limits = decode_limits(feature(kLimitsId));
  ASSERT_TRUE(limits) << limits.error().what;
  EXPECT_TRUE(limits->has_orientation && limits->knows_held && limits->has_torque);
  EXPECT_EQ(limits->buttons, 2);
  EXPECT_EQ(limits->rate_hz, 1000);
  EXPECT_EQ(limits->watchdog_ms, 20);
  EXPECT_LT((limits->workspace_min_m - Vec3(-0.1, -0.2, -0.3)).norm(), 2e-7);
  EXPECT_LT((limits->workspace_max_m - Vec3(0.11, 0.22, 0.33)).norm(), 2e-7);
  EXPECT_DOUBLE_EQ(limits->max_force_n, 7.5);
  EXPECT_DOUBLE_EQ(limits->continuous_force_n, 2.25);
  EXPECT_DOUBLE_EQ(limits->max_slew_n_per_s, 2000.0);
  EXPECT_DOUBLE_EQ(limits->max_stiffness_n_per_m, 1500.0);
  EXPECT_DOUBLE_EQ(limits->max_torque_nm, 0.125);
  EXPECT_DOUBLE_EQ(limits->max_torque_slew_nm_per_s, 50.0);
  EXPECT_DOUBLE_EQ(limits->peak_s, 4.5);
  EXPECT_DOUBLE_EQ(limits->max_speed_m_per_s, 3.0);
}

TEST(HaptonHidReports, NamesMayFillTheirFieldToTheLastByte) {
  const auto names = decode_names(feature(kNamesId));
  ASSERT_TRUE(names);
  EXPECT_EQ(names->model, "Test arm");
  EXPECT_EQ(names->serial, "SN-0042");
  EXPECT_EQ(names->firmware, "1.2.3");
  hapton_hid_limits limits = maker_limits();
  limits.serial = "0123456789abcdefTOO LONG";
  EXPECT_EQ(decode_names(feature(kNamesId, limits))->serial, "0123456789abcdef");
}

TEST(HaptonHidReports, ImpossibleLimitsAreRejectedWithAReason) {
  const auto rejection_with = [](auto&& change) {
    hapton_hid_limits limits = maker_limits();
    change(limits);
    return rejection(limits);
  };
  EXPECT_EQ(rejection(maker_limits()), "accepted");
  EXPECT_THAT(rejection_with([](auto& l) { l.watchdog_ms = 0; }), HasSubstr("watchdog takes 0 ms"));
  EXPECT_THAT(rejection_with([](auto& l) { l.watchdog_ms = 500; }), HasSubstr("watchdog takes 500 ms"));
  EXPECT_THAT(rejection_with([](auto& l) { l.rate_hz = 10; }), HasSubstr("10 times a second"));
  EXPECT_THAT(rejection_with([](auto& l) { l.workspace_max_m[1] = -0.5f; }), HasSubstr("workspace"));
  EXPECT_THAT(rejection_with([](auto& l) { l.max_force_n = 0.0f; }), HasSubstr("force limits are 0 N"));
  EXPECT_THAT(rejection_with([](auto& l) { l.max_force_n = 4000.0f; }), HasSubstr("force limits"));
  EXPECT_THAT(rejection_with([](auto& l) { l.continuous_force_n = 8.0f; }), HasSubstr("8 N (continuous)"));
  EXPECT_THAT(rejection_with([](auto& l) { l.max_slew_n_per_s = 0.0f; }), HasSubstr("how fast"));
  EXPECT_THAT(rejection_with([](auto& l) { l.max_torque_nm = 0.0f; }), HasSubstr("torque limits are 0 Nm"));
  EXPECT_EQ(rejection_with([](auto& l) {
              l.has_torque = false;
              l.max_torque_nm = 0.0f;
            }),
            "accepted");
}

// Each number at the edge of what is allowed, in the units of the report.
TEST(HaptonHidReports, LimitsAreAllowedUpToTheirEdges) {
  struct Row {
    std::size_t offset, bytes;
    std::int64_t good, bad;
    const char* why;
  };
  const Row rows[] = {{8, 2, 100, 99, "99 times a second"},
                      {10, 2, 5, 4, "watchdog takes 4 ms"},
                      {10, 2, 100, 101, "watchdog takes 101 ms"},
                      {24, 4, -999'999, -1'000'000, "its workspace is 0 x"},  // the other end of the workspace is at -0.1 m
                      {12, 4, -15'000'000, -15'000'001, "its workspace is 3 x"},
                      {36, 4, 200'000'000, 200'000'001, "force limits are 200 N"},
                      {36, 4, 2'250'000, 2'249'999, "and 2.25 N (continuous)"},
                      {40, 4, 7'500'000, 7'500'001, "and 7.5 N (continuous)"},
                      {44, 4, 1, 0, "how fast"},
                      {52, 4, 20'000'000, 20'000'001, "torque limits are 20 Nm"},
                      {52, 4, 1, 0, "torque limits are 0 Nm"},
                      {56, 4, 1, 0, "and 0 Nm/s"}};
  for (const Row& row : rows) {
    const auto decoded_with = [&](std::int64_t value) {
      Bytes report = feature(kLimitsId);
      // For the rows that test the size of the workspace, its other end is at 1.5 m.
      if (row.offset == 12) {
        for (std::size_t n = 0; n < 4; ++n) report[24 + n] = static_cast<std::uint8_t>(15'000'000 >> (8 * n));
      }
      for (std::size_t n = 0; n < row.bytes; ++n)
        report[row.offset + n] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * n));
      return decode_limits(report);
    };
    EXPECT_TRUE(decoded_with(row.good)) << row.why;
    const auto rejected = decoded_with(row.bad);
    ASSERT_FALSE(rejected) << row.why;
    EXPECT_THAT(rejected.error().what, HasSubstr(row.why));
  }
}

TEST(HaptonHidReports, EachBitOfAnAbilityAndOfTheStatusIsItsOwn) {
  for (const int bits : {0, 1, 2, 4}) {
    Bytes report = feature(kLimitsId);
    report[2] = static_cast<std::uint8_t>(bits);
    const auto limits = decode_limits(report);
    ASSERT_TRUE(limits);
    EXPECT_EQ(limits->has_orientation, bits == 1);
    EXPECT_EQ(limits->knows_held, bits == 2);
    EXPECT_EQ(limits->has_torque, bits == 4);
    EXPECT_EQ(limits->max_torque_nm, bits == 4 ? 0.125 : 0.0);
    EXPECT_EQ(limits->max_torque_slew_nm_per_s, bits == 4 ? 50.0 : 0.0);
  }
  const hapton_hid_limits limits = maker_limits();
  hapton_hid_device device;
  hapton_hid_init(&device, &limits);
  const hapton_hid_measured measured = measured_at_rest();
  Bytes report(kStateBytes);
  hapton_hid_state(&device, &measured, 0, report.data());
  for (const int bits : {0, 1, 2, 4, 8, 16, 32}) {
    report[1] = static_cast<std::uint8_t>(bits);
    const auto state = decode_state(report);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->is_calibrated, bits == 1);
    EXPECT_EQ(state->is_on, bits == 2);
    EXPECT_EQ(state->is_held, bits == 4);
    EXPECT_EQ(state->has_tripped, bits == 8);
    EXPECT_EQ(state->is_hot, bits == 16);
    EXPECT_EQ(state->has_fault, bits == 32);
  }
  // The temperature is in steps of 1/200; the length of a rotation's quaternion must be 1 within 1 %.
  for (const int temperature : {0, 100, 254}) {
    report[34] = static_cast<std::uint8_t>(temperature);
    EXPECT_DOUBLE_EQ(decode_state(report)->temperature, temperature / 200.0);
  }
  for (const auto& [w, is_good] : {std::pair{32'472, true}, {32'407, false}}) {
    report[26] = static_cast<std::uint8_t>(w);
    report[27] = static_cast<std::uint8_t>(w >> 8);
    EXPECT_EQ(decode_state(report).has_value(), is_good) << w;
  }
}

TEST(HaptonHidReports, AnotherVersionAndAForeignDeviceAreDistinguished) {
  Bytes report = feature(kLimitsId);
  report[1] = 2;
  EXPECT_THAT(decode_limits(report).error().what, HasSubstr("version 2"));
  report[4] = 'X';
  EXPECT_THAT(decode_limits(report).error().what, HasSubstr("does not say HAPT"));
  report = feature(kLimitsId);
  ASSERT_TRUE(decode_limits(report));
  report.pop_back();
  EXPECT_FALSE(decode_limits(report)) << "a byte too short";
  EXPECT_FALSE(decode_names(Bytes(57, 4)));
}

TEST(HaptonHidReports, AStateComesThroughWithinItsResolution) {
  const hapton_hid_limits limits = maker_limits();
  hapton_hid_device device;
  hapton_hid_init(&device, &limits);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 1000; ++trial) {
    const Quat q = Quat(uniform(random), uniform(random), uniform(random), uniform(random)).normalized();
    const Vec3 p = 0.3 * Vec3(uniform(random), uniform(random), uniform(random));
    hapton_hid_measured measured = measured_at_rest();
    for (int n = 0; n < 3; ++n) measured.position_m[n] = static_cast<float>(p[n]);
    for (int n = 0; n < 4; ++n) measured.orientation[n] = static_cast<float>(q.coeffs()[n]);
    measured.is_held = trial % 2 == 0;
    measured.is_hot = trial % 3 == 0;
    measured.has_fault = trial == 500;  // from then on the device keeps the fault
    measured.buttons = static_cast<std::uint32_t>(random());
    measured.temperature = trial % 7 == 0 ? -1.0f : 0.5f;
    Bytes report(kStateBytes);
    hapton_hid_state(&device, &measured, 0xFFFFFF00U + static_cast<std::uint32_t>(trial), report.data());
    const auto state = decode_state(report);
    ASSERT_TRUE(state);
    EXPECT_LT((state->position_m - p).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LT(state->orientation.angularDistance(q), 1e-4);
    EXPECT_EQ(state->sequence, static_cast<std::uint16_t>(trial));
    EXPECT_EQ(state->time_us, 0xFFFFFF00U + static_cast<std::uint32_t>(trial));
    EXPECT_EQ(state->buttons, measured.buttons);
    EXPECT_TRUE(state->is_calibrated);
    EXPECT_EQ(state->is_held, trial % 2 == 0);
    EXPECT_EQ(state->is_hot, trial % 3 == 0);
    EXPECT_EQ(state->has_fault, trial >= 500);
    EXPECT_DOUBLE_EQ(state->temperature, trial % 7 == 0 ? -1.0 : 0.5);
  }
}

TEST(HaptonHidReports, AForceComesThroughToTheMicronewton) {
  const hapton_hid_limits limits = maker_limits();
  hapton_hid_device device;
  hapton_hid_init(&device, &limits);
  const auto off = encode_force({.is_on = false, .sequence = 1});
  const auto on = encode_force({.is_on = true, .sequence = 2, .force_n = Vec3(1.25, -2.5, 3e-6), .torque_nm = Vec3(0.0625, 0, -1e-6)});
  EXPECT_TRUE(hapton_hid_take_force(&device, off.data(), off.size(), 1000));
  EXPECT_TRUE(hapton_hid_take_force(&device, on.data(), on.size(), 2000));
  float force[3], torque[3];
  EXPECT_TRUE(hapton_hid_motors(&device, 2000, force, torque));
  EXPECT_FLOAT_EQ(force[0], 1.25f);
  EXPECT_FLOAT_EQ(force[1], -2.5f);
  EXPECT_FLOAT_EQ(force[2], 3e-6f);
  EXPECT_FLOAT_EQ(torque[0], 0.0625f);
  EXPECT_FLOAT_EQ(torque[2], -1e-6f);
}

TEST(HaptonHidReports, NaNIsSentAsZeroAndTooLargeAForceAsTheLargest) {
  const auto report = encode_force(
      {.is_on = true, .force_n = Vec3(std::numeric_limits<double>::quiet_NaN(), 1e300, -std::numeric_limits<double>::infinity())});
  const auto at = [&](std::size_t byte) {
    return static_cast<std::int32_t>(report[byte] | (report[byte + 1] << 8) | (report[byte + 2] << 16) |
                                     (std::uint32_t{report[byte + 3]} << 24));
  };
  EXPECT_EQ(at(8), 0);
  EXPECT_EQ(at(12), 2147483647);
  EXPECT_EQ(at(16), -2147483647);
}

TEST(HaptonHidReports, ShortForeignAndGarbledStatesAreRejected) {
  const hapton_hid_limits limits = maker_limits();
  hapton_hid_device device;
  hapton_hid_init(&device, &limits);
  const hapton_hid_measured measured = measured_at_rest();
  Bytes report(kStateBytes);
  hapton_hid_state(&device, &measured, 0, report.data());
  for (std::size_t size = 0; size < kStateBytes; ++size) EXPECT_FALSE(decode_state(std::span(report).first(size)));
  Bytes longer = report;
  longer.push_back(0xAA);
  EXPECT_TRUE(decode_state(longer)) << "a later version may add to it";
  report[0] = 9;
  EXPECT_FALSE(decode_state(report));
  report[0] = kStateId;
  std::fill_n(report.begin() + 20, 8, std::uint8_t{0});
  EXPECT_FALSE(decode_state(report)) << "a quaternion of length zero";
}

TEST(HaptonHidReports, AnyBytesGiveNothingOrFiniteNumbers) {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 100'000; ++trial) {
    Bytes bytes(random() % 70);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (!bytes.empty() && trial % 2 == 0) bytes[0] = static_cast<std::uint8_t>(1 + random() % 4);
    if (const auto state = decode_state(bytes)) {
      ASSERT_TRUE(state->position_m.allFinite());
      ASSERT_NEAR(state->orientation.norm(), 1.0, 1e-9);
    }
    (void)decode_limits(bytes);
    (void)decode_names(bytes);
  }
}

// --- the maker's side (docs/hid/hapton_hid_device.c) ---

class MakersDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    const hapton_hid_limits limits = maker_limits();
    hapton_hid_init(&device_, &limits);
  }
  void send_force(bool is_on, std::uint32_t now_us, const Vec3& force_n = Vec3::UnitX()) {
    const auto report = encode_force({.is_on = is_on, .sequence = ++sequence_, .force_n = is_on ? force_n : Vec3::Zero()});
    EXPECT_TRUE(hapton_hid_take_force(&device_, report.data(), report.size(), now_us));
  }
  double force_n_at(std::uint32_t now_us) {
    float force[3], torque[3];
    const bool is_on = hapton_hid_motors(&device_, now_us, force, torque);
    const double n = std::hypot(force[0], force[1], force[2]);
    EXPECT_TRUE(is_on || n == 0.0);
    return n;
  }
  State state(std::uint32_t now_us, bool has_fault = false) {
    hapton_hid_measured measured = measured_at_rest();
    measured.has_fault = has_fault;
    Bytes report(kStateBytes);
    hapton_hid_state(&device_, &measured, now_us, report.data());
    return *decode_state(report);
  }

  hapton_hid_device device_;
  std::uint16_t sequence_ = 0;
};

TEST_F(MakersDevice, ExertsForceOnlyAfterItWasSwitchedOffOnce) {
  send_force(true, 1000);
  EXPECT_EQ(force_n_at(1000), 0.0);
  send_force(false, 2000);
  EXPECT_EQ(force_n_at(2000), 0.0);
  send_force(true, 3000);
  EXPECT_EQ(force_n_at(3000), 1.0);
  EXPECT_TRUE(state(3000).is_on);
  EXPECT_EQ(state(3000).newest_force, sequence_);
}

TEST_F(MakersDevice, ReleasesOnTimeoutAndStaysOffUntilSwitchedOff) {
  send_force(false, 1000);
  send_force(true, 2000);
  EXPECT_EQ(force_n_at(22'000), 1.0);
  EXPECT_EQ(force_n_at(22'001), 0.0);
  EXPECT_TRUE(state(22'001).has_tripped);
  send_force(true, 23'000);
  EXPECT_EQ(force_n_at(23'000), 0.0);
  send_force(false, 24'000);
  EXPECT_FALSE(state(24'000).has_tripped);
  send_force(true, 25'000);
  EXPECT_EQ(force_n_at(25'000), 1.0);
}

TEST_F(MakersDevice, AFaultTurnsTheMotorsOffUntilThePowerIsCycled) {
  for (const bool is_in_measurement : {true, false}) {
    SetUp();
    send_force(false, 1000);
    send_force(true, 2000);
    ASSERT_EQ(force_n_at(2000), 1.0);
    if (is_in_measurement) {
      EXPECT_TRUE(state(2100, true).has_fault);
    } else {
      hapton_hid_fault(&device_);
    }
    EXPECT_EQ(force_n_at(2100), 0.0);
    EXPECT_FALSE(state(2200).is_on);
    EXPECT_TRUE(state(2200).has_fault);
    send_force(true, 3000);
    EXPECT_EQ(force_n_at(3000), 0.0);
    send_force(false, 4000);
    send_force(true, 5000);
    EXPECT_EQ(force_n_at(5000), 0.0) << "arming does not clear a fault";
    EXPECT_TRUE(state(5000).has_fault);
    EXPECT_EQ(state(5000).newest_force, sequence_) << "reports are still received";
  }
  SetUp();
  send_force(false, 6000);
  send_force(true, 7000);
  EXPECT_EQ(force_n_at(7000), 1.0);
  EXPECT_FALSE(state(7000).has_fault);
}

TEST_F(MakersDevice, TheWatchdogDoesNotTripWhileTheMotorsAreOff) {
  EXPECT_FALSE(state(900'000).has_tripped) << "before the first report";
  send_force(false, 1'000'000);
  EXPECT_FALSE(state(9'000'000).has_tripped) << "after one that left them off";
  send_force(true, 9'000'000);
  EXPECT_EQ(force_n_at(9'000'000), 1.0) << "still armed";
  send_force(false, 9'001'000);
  EXPECT_FALSE(state(20'000'000).has_tripped) << "after they were turned off";
}

TEST_F(MakersDevice, TheNewestForceIsTheNewestReportObeyedOrNot) {
  EXPECT_EQ(state(0).newest_force, 0) << "none yet";
  send_force(true, 1000);
  EXPECT_EQ(state(1000).newest_force, 1) << "not armed";
  send_force(false, 2000);
  EXPECT_EQ(state(2000).newest_force, 2);
  send_force(true, 3000);
  EXPECT_TRUE(state(50'000).has_tripped);
  send_force(true, 51'000);
  EXPECT_EQ(state(51'000).newest_force, 4) << "its watchdog has tripped";
}

TEST_F(MakersDevice, KeepsItsOwnForceLimitWhateverIsRequested) {
  send_force(false, 1000);
  send_force(true, 2000, Vec3(300.0, 400.0, 0.0));
  EXPECT_NEAR(force_n_at(2000), 7.5, 1e-5);
}

TEST_F(MakersDevice, WatchesTheTimeAcrossTheWrapOfItsClock) {
  send_force(false, 0xFFFFF000U);
  send_force(true, 0xFFFFFF00U);
  EXPECT_EQ(force_n_at(0x00000100U), 1.0);
  EXPECT_EQ(force_n_at(0x00010000U), 0.0);
}

TEST_F(MakersDevice, RejectsOtherReports) {
  const auto report = encode_force({.is_on = false});
  EXPECT_FALSE(hapton_hid_take_force(&device_, report.data(), report.size() - 1, 0));
  Bytes foreign(report.begin(), report.end());
  foreign[0] = 7;
  EXPECT_FALSE(hapton_hid_take_force(&device_, foreign.data(), foreign.size(), 0));
  EXPECT_EQ(hapton_hid_feature(&device_, 9, foreign.data(), foreign.size()), 0U);
  EXPECT_EQ(hapton_hid_feature(&device_, kLimitsId, foreign.data(), 10), 0U);
}

// --- the document ---

std::string read_document() {
  std::ifstream file(std::string(HAPTON_SOURCE_DIR) + "/docs/hid.md");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// The text from this heading to the next heading of the second level ("## ").
std::string section(const std::string& text, const std::string& heading) {
  const std::size_t begin = text.find("\n" + heading);
  if (begin == std::string::npos) return {};
  const std::size_t end = text.find("\n## ", begin + 1);
  return text.substr(begin, end - begin);
}

TEST(HidDocument, HasTheDescriptorByteForByte) {
  const std::string text = section(read_document(), "## Report descriptor");
  const std::size_t begin = text.find("```"), end = text.find("```", begin + 3);
  ASSERT_NE(end, std::string::npos);
  const std::string block = text.substr(begin + 3, end - begin - 3);
  Bytes bytes;
  std::istringstream lines(block);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream tokens(line.substr(0, line.find(';')));
    for (std::string token; tokens >> token;) bytes.push_back(static_cast<std::uint8_t>(std::stoi(token, nullptr, 16)));
  }
  EXPECT_EQ(bytes, Bytes(std::begin(hapton_hid_descriptor), std::end(hapton_hid_descriptor)));
}

// Each table of a report lists its fields without a gap, and ends where the report ends.
TEST(HidDocument, ListsTheBytesOfEachReportWithoutAGap) {
  const std::string text = read_document();
  const std::vector<std::pair<std::string, std::size_t>> reports = {{"## Input report 1", kStateBytes},
                                                                    {"## Output report 2", kForceBytes},
                                                                    {"## Feature report 3", kLimitsBytes},
                                                                    {"## Feature report 4", kNamesBytes}};
  static const std::regex kRow(R"(\n\| (\d+) \| (\d+) \|)");
  for (const auto& [heading, size] : reports) {
    const std::string table = section(text, heading);
    std::size_t next = 0;
    for (auto row = std::sregex_iterator(table.begin(), table.end(), kRow); row != std::sregex_iterator(); ++row) {
      EXPECT_EQ(std::stoul((*row)[1]), next) << heading;
      next += std::stoul((*row)[2]);
    }
    EXPECT_EQ(next, size) << heading;
  }
}

}  // namespace
}  // namespace hapton::hapton_hid
