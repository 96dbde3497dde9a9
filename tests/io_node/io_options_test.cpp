#include "io_node/io_options.h"

#include <gtest/gtest.h>

#include <fstream>
#include <vector>

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
  EXPECT_EQ(std::get<int>(parse({"--help"})), 0);
}

TEST(IoOptions, ReadsAConfigFileThatTheCommandLineOverrides) {
  const std::string path = testing::TempDir() + "io_options_test.toml";
  std::ofstream(path) << "rate = 2000\nseed = 9\n";
  const auto options = std::get<IoOptions>(parse({"--config", path.c_str(), "--seed", "3"}));
  EXPECT_EQ(options.rate_hz, 2000.0);
  EXPECT_EQ(options.device.seed, 3U);
}

}  // namespace
}  // namespace hapton
