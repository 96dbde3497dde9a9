#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "closed_loop/hand_model.h"
#include "closed_loop/turning_axis.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

CommandRun run(std::vector<std::string> words) {
  words.insert(words.begin(), "loop");
  return run_hapton(std::move(words));
}

// The cells of tests/closed_loop/stability_test.cpp, as a person asks for them.
TEST(LoopCommand, ZWidthOfALoopOfOnesOwn) {
  const CommandRun seen =
      run({"zwidth", "--mass-kg", "0.225", "--damping-ns-per-m", "5", "--hand-stiffness-n-per-m", "500", "--delay", "100", "--json"});
  ASSERT_EQ(seen.code, 0) << seen.err;
  const auto json = nlohmann::json::parse(seen.out);
  EXPECT_EQ(std::round(json["stable_stiffness_n_per_m"].get<double>()), 359.0);
  EXPECT_EQ(std::round(json["passive_stiffness_n_per_m"].get<double>()), 50.0);
}

TEST(LoopCommand, SeveralCellsAreAList) {
  const auto json = nlohmann::json::parse(run({"zwidth", "--device", "touch,falcon", "--rate", "1000,4000", "--json"}).out);
  EXPECT_EQ(json.size(), 4U);
}

TEST(LoopCommand, JointsAreThoseOfTheFlagInItsOrder) {
  const auto modes_of = [](std::vector<std::string> words) {
    words.insert(words.begin(), {"zwidth", "--device", "premium-1.5", "--json"});
    const CommandRun seen = run(std::move(words));
    EXPECT_EQ(seen.code, 0) << seen.err;
    return nlohmann::json::parse(seen.out)["inputs"]["modes"];
  };
  const auto two = modes_of({"--joint", "0.01,3500,2", "--joint", "0.005,8000,0"});
  const nlohmann::json first = {{"mass_kg", 0.01}, {"stiffness_n_per_m", 3500.0}, {"damping_ns_per_m", 2.0}};
  const nlohmann::json second = {{"mass_kg", 0.005}, {"stiffness_n_per_m", 8000.0}, {"damping_ns_per_m", 0.0}};
  EXPECT_EQ(two, (nlohmann::json{first, second}));
  EXPECT_EQ(modes_of({"--joint", "0.005,8000,0", "--joint", "0.01,3500,2"}), (nlohmann::json{second, first}));
  const CommandRun three = run({"zwidth", "--device", "premium-1.5", "--joint", "0.01,1,1", "--joint", "0.01,1,1", "--joint", "0.01,1,1"});
  EXPECT_NE(three.code, 0);
  EXPECT_THAT(three.err, HasSubstr("2 joints at most, not 3"));
}

TEST(LoopCommand, PressSaysWhetherItGeneratedEnergy) {
  const CommandRun calm = run({"press", "--device", "omega.3", "--stiffness", "500", "--json"});
  ASSERT_EQ(calm.code, 0) << calm.err;
  EXPECT_LT(nlohmann::json::parse(calm.out)["generated_j"].get<double>(), 0.0);
  const auto wild = nlohmann::json::parse(run({"press", "--device", "omega.3", "--stiffness", "3000", "--delay", "10", "--json"}).out);
  EXPECT_GT(wild["generated_j"].get<double>(), 0.0);
  EXPECT_GT(wild["limit_cycle_m"].get<double>(), 1e-5);
}

// The strongest line of the file above 5 Hz is the buzz that is printed.
TEST(LoopCommand, PressWritesTheSpectrumOfTheBuzz) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / ("loop_spectrum_" + std::to_string(::getpid()) + ".csv");
  const CommandRun seen =
      run({"press", "--device", "omega.3", "--stiffness", "3000", "--delay", "10", "--spectrum", file.string(), "--json"});
  ASSERT_EQ(seen.code, 0) << seen.err;
  std::ifstream stream(file);
  std::string line;
  ASSERT_TRUE(std::getline(stream, line));
  EXPECT_EQ(line, "frequency_hz,force_n");
  double strongest_hz = 0.0;
  double strongest_n = 0.0;
  double last_hz = 0.0;
  while (std::getline(stream, line)) {
    const std::size_t comma = line.find(',');
    ASSERT_NE(comma, std::string::npos) << line;
    const double frequency_hz = std::stod(line.substr(0, comma));
    const double force_n = std::stod(line.substr(comma + 1));
    EXPECT_GT(frequency_hz, last_hz);
    last_hz = frequency_hz;
    if (frequency_hz >= 5.0 && force_n > strongest_n) strongest_hz = frequency_hz, strongest_n = force_n;
  }
  std::filesystem::remove(file);
  const auto json = nlohmann::json::parse(seen.out);
  EXPECT_GT(last_hz, 490.0);
  EXPECT_DOUBLE_EQ(strongest_hz, json["buzz_hz"].get<double>());
  EXPECT_DOUBLE_EQ(strongest_n, json["buzz_n"].get<double>());
}

TEST(LoopCommand, PressWithThePassivityControllerGeneratesNone) {
  const CommandRun seen = run({"press", "--device", "omega.3", "--stiffness", "3000", "--delay", "10", "--passivity", "--json"});
  ASSERT_EQ(seen.code, 0) << seen.err;
  const auto json = nlohmann::json::parse(seen.out);
  EXPECT_LT(json["generated_j"].get<double>(), 0.0);
  EXPECT_GT(json["passivity"]["acted"].get<int>(), 0);
}

TEST(LoopCommand, PressOnAMeshThroughTheGovernor) {
  const CommandRun seen = run({"press", "--device", "touch", "--mesh", "--gate", "governor", "--impedance"});
  ASSERT_EQ(seen.code, 0) << seen.err;
  EXPECT_THAT(seen.out, HasSubstr("bounded"));
  EXPECT_THAT(seen.out, HasSubstr("rendered at"));
}

TEST(LoopCommand, RecommendReadsAMeasuredLatency) {
  const std::filesystem::path report = std::filesystem::temp_directory_path() / ("loop_report_" + std::to_string(::getpid()) + ".json");
  std::ofstream(report)
      << R"({"schema":"hapton.report/4","hops":{"round_trip":{"n":10,"p99_9_us":30000.0}},"rates_hz":{"servo_requested":1000}})";
  const CommandRun seen = run({"recommend", "--device", "touch", "--latency", report.string(), "--json"});
  std::filesystem::remove(report);
  ASSERT_EQ(seen.code, 0) << seen.err;
  const auto json = nlohmann::json::parse(seen.out);
  EXPECT_DOUBLE_EQ(json["delay_ms"].get<double>(), 30.0);
  EXPECT_EQ(json["limited_by"], "stability");
  EXPECT_LT(json["recommended_stiffness_n_per_m"].get<double>(), json["stable_stiffness_n_per_m"].get<double>());
  EXPECT_TRUE(json["recommended_rotational_stiffness_nm_per_rad"].is_null()) << "no motor turns its stylus";
}

TEST(LoopCommand, RecommendsARotationalStiffnessWhereMotorsTurnTheStylus) {
  const CommandRun seen = run({"recommend", "--device", "model-a-6dof", "--hand", "light", "--delay", "1", "--json"});
  ASSERT_EQ(seen.code, 0) << seen.err;
  const double safe = nlohmann::json::parse(seen.out)["recommended_rotational_stiffness_nm_per_rad"].get<double>();
  EXPECT_NEAR(safe, recommend_rotational_stiffness(*find_hand_preset("light"), 0.17, 1000.0, 1e-3), 1e-9);
  const CommandRun said = run({"recommend", "--device", "model-a-6dof", "--hand", "light", "--delay", "1"});
  EXPECT_THAT(said.out, HasSubstr("--rotational-stiffness 0.83"));
}

TEST(LoopCommand, BadInputGetsOneLine) {
  for (const auto& [words, reason] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"zwidth"}, "give --device"},
           {{"zwidth", "--device", "tuch"}, "did you mean 'touch'?"},
           {{"zwidth", "--device", "touch", "--rate", "0"}, "--rate: 0 is not between"},
           {{"zwidth", "--device", "touch", "--delay", "-1"}, "--delay: -1 is not between"},
           {{"zwidth", "--device", "touch", "--shard", "3/2"}, "--shard '3/2'"},
           {{"press", "--device", "touch,falcon"}, "one device and one hand"},
           {{"press", "--mass-kg", "1", "--damping-ns-per-m", "1", "--gate", "governor"}, "needs a device with limits"},
           {{"recommend", "--device", "touch"}, "give --latency"},
           {{"recommend", "--device", "touch", "--latency", "/nowhere"}, "/nowhere"},
           {{"merge", "/nowhere", "--out", "/nowhere/all.csv"}, "cannot be read"}}) {
    const CommandRun seen = run(words);
    EXPECT_EQ(seen.code, 1) << reason;
    EXPECT_THAT(seen.err, HasSubstr(reason));
    EXPECT_EQ(std::count(seen.err.begin(), seen.err.end(), '\n'), 1) << seen.err;
    EXPECT_EQ(seen.out, "");
  }
}

}  // namespace
}  // namespace hapton
