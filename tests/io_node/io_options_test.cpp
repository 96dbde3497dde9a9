#include "io_node/io_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "tests/support/option_range.h"

namespace hapton {
namespace {

std::variant<IoOptions, int> parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "io_node");
  return parse_io_options(static_cast<int>(arguments.size()), arguments.data());
}

TEST(IoOptions, HasTheDefaultsOfASingleHost) {
  const auto options = std::get<IoOptions>(parse({}));
  EXPECT_EQ(options.bind, "127.0.0.1:4950");
  EXPECT_EQ(options.device.name, "simulated");
  EXPECT_EQ(options.rate_hz, 1000.0);
  EXPECT_EQ(options.vision_rate_hz, 240.0);
  EXPECT_EQ(options.realtime.mode, RealtimeMode::attempt);
  EXPECT_EQ(options.touch, TouchChoice::automatic);
  EXPECT_EQ(std::get<IoOptions>(parse({"--touch", "remote"})).touch, TouchChoice::remote);
  EXPECT_EQ(std::get<IoOptions>(parse({"--touch", "patch"})).touch, TouchChoice::patch);
}

TEST(IoOptions, ReadsFlags) {
  const auto options = std::get<IoOptions>(
      parse({"--rate", "4000",        "--device", "replay",        "--trajectory", "t.csv",        "--loop",      "--rt",
             "off",    "--seed",      "42",       "--max-force",   "2.5",          "--echo-probe", "127.0.0.1:9", "--cpu",
             "1",      "--device-id", "7",        "--device-file", "mine.toml"}));
  EXPECT_EQ(options.rate_hz, 4000.0);
  EXPECT_EQ(options.device.name, "replay");
  EXPECT_EQ(options.device.id, "7");
  EXPECT_EQ(options.device.file, "mine.toml");
  EXPECT_EQ(options.device.trajectory, "t.csv");
  EXPECT_TRUE(options.device.loop);
  EXPECT_EQ(options.realtime.mode, RealtimeMode::off);
  EXPECT_EQ(options.realtime.cpu, 1);
  EXPECT_EQ(options.device.seed, 42U);
  EXPECT_EQ(options.device.max_force_n, 2.5);
  EXPECT_EQ(options.echo_probe, "127.0.0.1:9");
}

TEST(IoOptions, ReadTheDevicesMechanicsForThePassivityController) {
  EXPECT_EQ(std::get<IoOptions>(parse({})).device.passive_mass_kg, 0.0);
  const auto options = std::get<IoOptions>(
      parse({"--passive-mass", "0.075", "--passive-damping", "0.2", "--passive-friction", "0.04", "--passive-step", "3e-5"}));
  EXPECT_EQ(options.device.passive_mass_kg, 0.075);
  EXPECT_EQ(options.device.passive_damping_ns_per_m, 0.2);
  EXPECT_EQ(options.device.passive_friction_n, 0.04);
  EXPECT_EQ(options.device.passive_position_step_m, 3e-5);
  EXPECT_TRUE(std::holds_alternative<int>(parse({"--passive-step", "3e-5"}))) << "without a mass it does nothing";
}

TEST(IoOptions, TheClutchTakesAButtonThatIsNotTheDeadMansSwitch) {
  EXPECT_EQ(std::get<IoOptions>(parse({})).device.clutch_button, 0);
  EXPECT_EQ(std::get<IoOptions>(parse({"--clutch-button", "1", "--dead-mans-switch", "2"})).device.clutch_button, 1);
  EXPECT_EQ(std::get<int>(parse({"--clutch-button", "2", "--dead-mans-switch", "2"})), 2);
  EXPECT_TRUE(std::holds_alternative<int>(parse({"--clutch-button", "33"})));
  EXPECT_TRUE(std::holds_alternative<int>(parse({"--devices", "two.toml", "--clutch-button", "2"})));
}

TEST(IoOptions, TheOldNameOfTheDeadMansSwitchCountsFromZero) {
  EXPECT_EQ(std::get<IoOptions>(parse({})).device.dead_mans_switch, 0);
  EXPECT_EQ(std::get<IoOptions>(parse({"--dead-mans-switch", "1"})).device.dead_mans_switch, 1);
  testing::internal::CaptureStderr();
  EXPECT_EQ(std::get<IoOptions>(parse({"--hold-button", "0"})).device.dead_mans_switch, 1);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("--hold-button 0 is now --dead-mans-switch 1"));
  EXPECT_EQ(std::get<IoOptions>(parse({"--hold-button", "-1"})).device.dead_mans_switch, 0);
  EXPECT_TRUE(std::holds_alternative<int>(parse({"--hold-button", "0", "--dead-mans-switch", "1"})));
  EXPECT_TRUE(std::holds_alternative<int>(parse({"--devices", "two.toml", "--dead-mans-switch", "1"})));
  EXPECT_TRUE(std::holds_alternative<int>(parse({"--devices", "two.toml", "--hold-button", "1"})));
}

TEST(IoOptions, OptionsForAllDevicesGoWithADevicesFile) {
  const auto options = std::get<IoOptions>(parse({"--devices", "desk.toml", "--rate", "2000", "--out", "/tmp"}));
  EXPECT_EQ(options.devices_file, "desk.toml");
  EXPECT_EQ(options.rate_hz, 2000.0);
}

TEST(IoOptions, VrpnIsOffUnlessAnAddressIsGiven) {
  EXPECT_EQ(std::get<IoOptions>(parse({})).vrpn, "");
  const auto options = std::get<IoOptions>(parse({"--vrpn", "127.0.0.1:3883", "--vrpn-name", "left"}));
  EXPECT_EQ(options.vrpn, "127.0.0.1:3883");
  EXPECT_EQ(options.vrpn_name, "left");
  EXPECT_TRUE(std::holds_alternative<int>(parse({"--vrpn"})));
}

TEST(IoOptions, RejectsWhatMakesNoSense) {
  for (const std::vector<const char*>& wrong : std::vector<std::vector<const char*>>{{"--rate", "249"},
                                                                                     {"--rate", "10001"},
                                                                                     {"--rate", "nan"},
                                                                                     {"--rate", "fast"},
                                                                                     {"--device", "sofa"},
                                                                                     {"--devices", "two.toml", "--bind", "127.0.0.1:0"},
                                                                                     {"--devices", "two.toml", "--device", "simulated"},
                                                                                     {"--devices", "two.toml", "--vrpn", "127.0.0.1:3883"},
                                                                                     {"--rt", "maybe"},
                                                                                     {"--max-force", "-1"},
                                                                                     {"--seconds", "-3"},
                                                                                     {"--unknown"},
                                                                                     {"stray"}}) {
    const auto parsed = parse(wrong);
    ASSERT_TRUE(std::holds_alternative<int>(parsed)) << wrong.front();
    EXPECT_NE(std::get<int>(parsed), 0) << wrong.front();
  }
  testing::internal::CaptureStdout();
  EXPECT_EQ(std::get<int>(parse({"--help"})), 0);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), testing::Not(testing::HasSubstr("Excludes: \n"))) << "of an option that is hidden";
}

TEST(IoOptions, ReadsAConfigFileThatTheCommandLineOverrides) {
  const std::string path = testing::TempDir() + "io_options_test.toml";
  std::ofstream(path) << "rate = 2000\nseed = 9\n";
  const auto options = std::get<IoOptions>(parse({"--config", path.c_str(), "--seed", "3"}));
  EXPECT_EQ(options.rate_hz, 2000.0);
  EXPECT_EQ(options.device.seed, 3U);
}

TEST(IoOptions, NumbersHaveTheRangesThatHelpNames) {
  const OptionRange<IoOptions> ranges[] = {
      {"--rate", "250", "10000", "249", "10001", [](const IoOptions& o) { return static_cast<double>(o.rate_hz); }},
      {"--vision-rate", "0", "10000", "-1", "10001", [](const IoOptions& o) { return static_cast<double>(o.vision_rate_hz); }},
      {"--seconds", "0", "1e9", "-0.1", "1.1e9", [](const IoOptions& o) { return static_cast<double>(o.seconds); }},
      {"--max-force", "0", "1000", "-0.1", "1001", [](const IoOptions& o) { return static_cast<double>(o.device.max_force_n); }},
      {"--max-slew", "0", "1e6", "-0.1", "1.1e6", [](const IoOptions& o) { return static_cast<double>(o.device.max_slew_n_per_s); }},
      {"--max-torque", "0", "1000", "-0.1", "1001", [](const IoOptions& o) { return static_cast<double>(o.device.max_torque_nm); }},
      {"--continuous-force", "0", "1000", "-0.1", "1001",
       [](const IoOptions& o) { return static_cast<double>(o.device.continuous_force_n); }},
      {"--max-speed", "0", "100", "-0.1", "100.1", [](const IoOptions& o) { return static_cast<double>(o.device.max_speed_m_per_s); }},
      {"--dead-mans-switch", "0", "32", "-1", "33", [](const IoOptions& o) { return static_cast<double>(o.device.dead_mans_switch); }},
      {"--hold-button", "-1", "31", "-2", "32", [](const IoOptions& o) { return o.device.dead_mans_switch - 1.0; }},
      {"--passive-mass", "0", "100", "-0.1", "100.1", [](const IoOptions& o) { return static_cast<double>(o.device.passive_mass_kg); }},
      {"--spin", "0", "0.5", "-0.01", "0.51", [](const IoOptions& o) { return static_cast<double>(o.spin_share); }},
      {"--spin-reply", "0", "1000", "-0.1", "1001", [](const IoOptions& o) { return static_cast<double>(o.reply_spin_us); }},
      {"--rt-priority", "0", "99", "-1", "100", [](const IoOptions& o) { return static_cast<double>(o.realtime.priority); }},
      {"--cpu", "-1", "4095", "-2", "4096", [](const IoOptions& o) { return static_cast<double>(o.realtime.cpu); }},
  };
  for (const auto& range : ranges) expect_range(range, parse);
  const OptionRange<IoOptions> controller_ranges[] = {
      {"--passive-damping", "0", "1000", "-0.1", "1001",
       [](const IoOptions& o) { return static_cast<double>(o.device.passive_damping_ns_per_m); }},
      {"--passive-friction", "0", "100", "-0.1", "100.1",
       [](const IoOptions& o) { return static_cast<double>(o.device.passive_friction_n); }},
      {"--passive-step", "0", "0.01", "-0.001", "0.011",
       [](const IoOptions& o) { return static_cast<double>(o.device.passive_position_step_m); }},
  };
  for (const auto& range : controller_ranges) expect_range(range, parse, {"--passive-mass", "0.1"});
  EXPECT_NE(std::get<int>(parse({"--passive-damping", "1"})), 0) << "without the mass it means nothing";
}

}  // namespace
}  // namespace hapton
