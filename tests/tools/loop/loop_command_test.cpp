#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "closed_loop/hand_model.h"
#include "closed_loop/turning_axis.h"
#include "tests/tools/command_run.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

CommandRun run_loop(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "loop");
  return run_hapton(std::move(arguments));
}

// The cells of tests/closed_loop/stability_test.cpp, as flags of the command.
TEST(LoopCommand, ZWidthOfALoopOfOnesOwn) {
  const CommandRun run =
      run_loop({"zwidth", "--mass-kg", "0.225", "--damping-ns-per-m", "5", "--hand-stiffness-n-per-m", "500", "--delay", "100", "--json"});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(std::round(json["stable_stiffness_n_per_m"].get<double>()), 359.0);
  EXPECT_EQ(std::round(json["passive_stiffness_n_per_m"].get<double>()), 50.0);
}

TEST(LoopCommand, SeveralCellsAreAList) {
  const auto json = nlohmann::json::parse(run_loop({"zwidth", "--device", "touch,falcon", "--rate", "1000,4000", "--json"}).out);
  EXPECT_EQ(json.size(), 4U);
}

TEST(LoopCommand, JointsAreThoseOfTheFlagInItsOrder) {
  const auto modes_of = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"zwidth", "--device", "premium-1.5", "--json"});
    const CommandRun run = run_loop(std::move(arguments));
    EXPECT_EQ(run.code, 0) << run.err;
    return nlohmann::json::parse(run.out)["inputs"]["modes"];
  };
  const auto two = modes_of({"--joint", "0.01,3500,2", "--joint", "0.005,8000,0"});
  const nlohmann::json first = {{"mass_kg", 0.01}, {"stiffness_n_per_m", 3500.0}, {"damping_ns_per_m", 2.0}};
  const nlohmann::json second = {{"mass_kg", 0.005}, {"stiffness_n_per_m", 8000.0}, {"damping_ns_per_m", 0.0}};
  EXPECT_EQ(two, (nlohmann::json{first, second}));
  EXPECT_EQ(modes_of({"--joint", "0.005,8000,0", "--joint", "0.01,3500,2"}), (nlohmann::json{second, first}));
  const CommandRun three =
      run_loop({"zwidth", "--device", "premium-1.5", "--joint", "0.01,1,1", "--joint", "0.01,1,1", "--joint", "0.01,1,1"});
  EXPECT_NE(three.code, 0);
  EXPECT_THAT(three.err, HasSubstr("2 joints at most, not 3"));
}

TEST(LoopCommand, PressSaysWhetherItGeneratedEnergy) {
  const CommandRun stable = run_loop({"press", "--device", "omega.3", "--stiffness", "500", "--json"});
  ASSERT_EQ(stable.code, 0) << stable.err;
  EXPECT_LT(nlohmann::json::parse(stable.out)["generated_j"].get<double>(), 0.0);
  const auto unstable =
      nlohmann::json::parse(run_loop({"press", "--device", "omega.3", "--stiffness", "3000", "--delay", "10", "--json"}).out);
  EXPECT_GT(unstable["generated_j"].get<double>(), 0.0);
  EXPECT_GT(unstable["limit_cycle_m"].get<double>(), 1e-5);
}

// The strongest line of the file above 5 Hz is the buzz that is printed.
TEST(LoopCommand, PressWritesTheSpectrumOfTheBuzz) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / ("loop_spectrum_" + std::to_string(::getpid()) + ".csv");
  const CommandRun run =
      run_loop({"press", "--device", "omega.3", "--stiffness", "3000", "--delay", "10", "--spectrum", file.string(), "--json"});
  ASSERT_EQ(run.code, 0) << run.err;
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
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_GT(last_hz, 490.0);
  EXPECT_DOUBLE_EQ(strongest_hz, json["buzz_hz"].get<double>());
  EXPECT_DOUBLE_EQ(strongest_n, json["buzz_n"].get<double>());
}

TEST(LoopCommand, PressWithThePassivityControllerGeneratesNone) {
  const CommandRun run = run_loop({"press", "--device", "omega.3", "--stiffness", "3000", "--delay", "10", "--passivity", "--json"});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_LT(json["generated_j"].get<double>(), 0.0);
  EXPECT_GT(json["passivity"]["acted"].get<int>(), 0);
}

TEST(LoopCommand, PressOnAMeshThroughTheGovernor) {
  const CommandRun run = run_loop({"press", "--device", "touch", "--mesh", "--gate", "governor", "--impedance"});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("bounded"));
  EXPECT_THAT(run.out, HasSubstr("rendered at"));
}

TEST(LoopCommand, RecommendReadsAMeasuredLatency) {
  const std::filesystem::path report = std::filesystem::temp_directory_path() / ("loop_report_" + std::to_string(::getpid()) + ".json");
  std::ofstream(report)
      << R"({"schema":"hapton.report/4","hops":{"round_trip":{"n":10,"p99_9_us":30000.0}},"rates_hz":{"servo_requested":1000}})";
  const CommandRun run = run_loop({"recommend", "--device", "touch", "--latency", report.string(), "--json"});
  std::filesystem::remove(report);
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_DOUBLE_EQ(json["delay_ms"].get<double>(), 30.0);
  EXPECT_EQ(json["limited_by"], "stability");
  EXPECT_LT(json["recommended_stiffness_n_per_m"].get<double>(), json["stable_stiffness_n_per_m"].get<double>());
  EXPECT_TRUE(json["recommended_rotational_stiffness_nm_per_rad"].is_null()) << "no motor turns its stylus";
}

// recommend looks at several hands if it is given none, and a loop from flags has none.
TEST(LoopCommand, RecommendTakesALoopFromFlagsInPlaceOfAHand) {
  const CommandRun run = run_loop({"recommend", "--mass-kg", "0.2", "--damping-ns-per-m", "5", "--delay", "1", "--json"});
  EXPECT_EQ(run.code, 0) << run.err;
  const CommandRun both = run_loop({"recommend", "--mass-kg", "0.2", "--damping-ns-per-m", "5", "--hand", "stylus"});
  EXPECT_NE(both.code, 0);
  EXPECT_THAT(both.err, HasSubstr("--hand excludes --mass-kg"));
}

TEST(LoopCommand, RecommendsARotationalStiffnessWhereMotorsTurnTheStylus) {
  const CommandRun run = run_loop({"recommend", "--device", "model-a-6dof", "--hand", "light", "--delay", "1", "--json"});
  ASSERT_EQ(run.code, 0) << run.err;
  const double safe = nlohmann::json::parse(run.out)["recommended_rotational_stiffness_nm_per_rad"].get<double>();
  EXPECT_NEAR(safe, recommend_rotational_stiffness(*find_hand_preset("light"), 0.17, 1000.0, 1e-3), 1e-9);
  const CommandRun text_run = run_loop({"recommend", "--device", "model-a-6dof", "--hand", "light", "--delay", "1"});
  EXPECT_THAT(text_run.out, HasSubstr("--rotational-stiffness 0.83"));
}

nlohmann::json recommend_json(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "recommend");
  arguments.push_back("--json");
  const CommandRun run = run_loop(std::move(arguments));
  EXPECT_EQ(run.code, 0) << run.err;
  return nlohmann::json::parse(run.out, nullptr, false);
}

// JSON has no infinity, so a value that is not a number stands for it.
double number_of(const nlohmann::json& advice, const char* name) {
  return advice[name].is_number() ? advice[name].get<double>() : std::numeric_limits<double>::infinity();
}

// Whoever holds the device: what is safe for the hand that allows least is safe for all.
TEST(LoopCommand, RecommendGoesByTheHandThatAllowsLeast) {
  const auto of_hand = [](const std::string& hand) { return recommend_json({"--device", "omega.3", "--delay", "0.5", "--hand", hand}); };
  const nlohmann::json all = of_hand("light,stylus,arm,firm");
  EXPECT_EQ(all["hand"], "light") << "as docs/choosing-a-device.md has it";
  EXPECT_EQ(all["limited_by"], "stability");
  for (const char* name : {"recommended_stiffness_n_per_m", "recommended_damping_ns_per_m", "recommended_viscosity_ns_per_m"}) {
    double least = std::numeric_limits<double>::infinity();
    for (const char* hand : {"light", "stylus", "arm", "firm"}) least = std::min(least, number_of(of_hand(hand), name));
    EXPECT_EQ(number_of(all, name), least) << name;
  }
  EXPECT_GT(number_of(of_hand("firm"), "recommended_stiffness_n_per_m"), number_of(all, "recommended_stiffness_n_per_m"));
  const auto stiffness_for_hand = [](const std::string& hand) {
    return number_of(recommend_json({"--device", "model-a-6dof", "--delay", "1", "--hand", hand}),
                     "recommended_rotational_stiffness_nm_per_rad");
  };
  EXPECT_EQ(stiffness_for_hand("light,firm"), std::min(stiffness_for_hand("light"), stiffness_for_hand("firm")));
}

TEST(LoopCommand, RecommendDoesNotGoBeyondTheDocumentedLimitOfTheDevice) {
  const nlohmann::json advice = recommend_json({"--device", "falcon", "--delay", "0.5"});
  EXPECT_EQ(advice["limited_by"], "device");
  EXPECT_EQ(advice["recommended_stiffness_n_per_m"], advice["device_stiffness_n_per_m"]);
  EXPECT_LT(number_of(advice, "recommended_stiffness_n_per_m"), 0.5 * number_of(advice, "stable_stiffness_n_per_m"));
}

TEST(LoopCommand, RecommendTakesRateAndDelayOfTheCommandLineBeforeThoseOfTheReport) {
  const std::filesystem::path report = std::filesystem::temp_directory_path() / ("loop_other_" + std::to_string(::getpid()) + ".json");
  std::ofstream(report)
      << R"({"schema":"hapton.report/4","hops":{"round_trip":{"n":10,"p99_9_us":30000.0}},"rates_hz":{"servo_requested":2000}})";
  const nlohmann::json from_report = recommend_json({"--device", "touch", "--latency", report.string()});
  const nlohmann::json with_flags = recommend_json({"--device", "touch", "--latency", report.string(), "--rate", "4000", "--delay", "2"});
  std::filesystem::remove(report);
  EXPECT_EQ(from_report["rate_hz"], 2000.0);
  EXPECT_DOUBLE_EQ(from_report["delay_ms"].get<double>(), 30.0);
  EXPECT_EQ(with_flags["rate_hz"], 4000.0);
  EXPECT_DOUBLE_EQ(with_flags["delay_ms"].get<double>(), 2.0);
}

TEST(LoopCommand, VelocityChoosesTheLeastLagThatIsQuietEnough) {
  const CommandRun run = run_loop({"velocity", "--device", "touch", "--damping", "2", "--json"});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  nlohmann::json chosen;
  double least_lag_s = std::numeric_limits<double>::infinity();
  for (const auto& row : json["rows"]) {
    EXPECT_DOUBLE_EQ(row["noise_n"].get<double>(), 2.0 * row["noise_m_per_s"].get<double>());
    if (row["noise_n"].get<double>() > json["most_noise_n"].get<double>() || row["lag_s"].get<double>() >= least_lag_s) continue;
    least_lag_s = row["lag_s"].get<double>();
    chosen = row["estimator"];
  }
  EXPECT_EQ(json["chosen"], chosen);
}

TEST(LoopCommand, BadInputGetsOneLine) {
  for (const auto& [arguments, reason] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"zwidth"}, "give --device"},
           {{"zwidth", "--device", "tuch"}, "did you mean 'touch'?"},
           {{"zwidth", "--device", "touch", "--rate", "0"}, "--rate: 0 is not between"},
           {{"zwidth", "--device", "touch", "--delay", "-1"}, "--delay: -1 is not between"},
           {{"zwidth", "--device", "touch", "--shard", "3/2"}, "--shard '3/2'"},
           {{"zwidth", "--device", "touch", "--csv", "hapton_a.png", "--plot", "./hapton_a.png"},
            "--csv and --plot are both ./hapton_a.png"},
           {{"press", "--device", "touch", "--csv", "hapton_a.csv", "--spectrum", "./hapton_a.csv"}, "--csv and --spectrum are both"},
           {{"press", "--device", "touch,falcon"}, "one device and one hand"},
           {{"press", "--mass-kg", "1", "--damping-ns-per-m", "1", "--gate", "governor"}, "needs a device with limits"},
           {{"recommend", "--device", "touch"}, "give --latency"},
           {{"recommend", "--device", "touch", "--latency", "/nowhere"}, "/nowhere"},
           {{"merge", "/nowhere", "--out", "/nowhere/all.csv"}, "cannot be read"}}) {
    const CommandRun run = run_loop(arguments);
    EXPECT_EQ(run.code, 1) << reason;
    EXPECT_THAT(run.err, HasSubstr(reason));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_EQ(run.out, "");
  }
}

}  // namespace
}  // namespace hapton
