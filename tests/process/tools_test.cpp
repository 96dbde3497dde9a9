// The tools that watch and measure a running system, as a person calls them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <regex>

#include "tests/process/system.h"

namespace hapton::process {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Runs `hapton` with these arguments and the key of this system.
Ended hapton(System& system, const std::vector<std::string>& words) {
  const auto ended = run("hapton", words, system.folder(), 2 * kPatience);
  EXPECT_TRUE(ended) << "still runs";
  return ended.value_or(Ended());
}

TEST(Top, ShowsNodesRatesLatenciesAndCountersAsText) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  const Ended once = hapton(system, {"top", "--hub", system.hub(), "--once"});
  EXPECT_EQ(once.exit_code, 0) << once.err;
  EXPECT_THAT(once.out, AllOf(HasSubstr("hub " + system.hub()), HasSubstr("haptics   127.0.0.1:"), HasSubstr("round_trip"),
                              HasSubstr("contact_samples"), Not(HasSubstr("\x1b"))));
  const Ended json = hapton(system, {"top", "--hub", system.hub(), "--once", "--json"});
  EXPECT_EQ(json.exit_code, 0) << json.err;
  const Json top = Json::parse(json.out, nullptr, false);
  ASSERT_TRUE(top.is_object()) << json.out;
  EXPECT_GT(top["per_second"]["samples"], 0.0);
  EXPECT_EQ(top["report"]["nodes"][0]["role"], "haptics");
  system.end_all();
}

TEST(Top, WithoutAHubSaysSo) {
  System system;
  const Ended none = hapton(system, {"top", "--hub", system.hub(), "--once"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("no reply from a hub at " + system.hub()));
}

// The reply to GET /metrics; empty if there is no server.
std::string read_metrics(int port) {
  const int client = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string received;
  if (::connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
    const std::string request = "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n";
    ::send(client, request.data(), request.size(), MSG_NOSIGNAL);
    char buffer[4096];
    for (ssize_t bytes = 0; (bytes = ::recv(client, buffer, sizeof buffer, 0)) > 0;)
      received.append(buffer, static_cast<std::size_t>(bytes));
  }
  ::close(client);
  return received;
}

TEST(Metrics, AreServedWhileTheSystemRuns) {
  System system({"--metrics", "127.0.0.1:0"});
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  std::smatch port;
  const std::string printed = system["io_node"].err();
  ASSERT_TRUE(std::regex_search(printed, port, std::regex("http://127\\.0\\.0\\.1:([0-9]+)/metrics"))) << printed;
  std::string text;
  const std::regex kContact("\nhapton_contact_samples_total [1-9][0-9]*\n");
  EXPECT_TRUE(System::wait_until([&] {
    text = read_metrics(std::stoi(port[1]));
    return std::regex_search(text, kContact);
  })) << text;
  EXPECT_THAT(text, AllOf(HasSubstr("200 OK"), HasSubstr("hapton_latency_seconds_bucket{hop=\"round_trip\",le=\"0.001\"} "),
                          HasSubstr("hapton_node_received_total{role=\"haptics\",address=\"127.0.0.1:")));
  system.end_all();
}

TEST(Metrics, OutsideLoopbackAreRejected) {
  System system({"--metrics", "0.0.0.0:9464"});
  system.start("io_node");
  const auto ended = system["io_node"].wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_THAT(ended->err, HasSubstr("this machine only"));
}

TEST(Latency, RunOfItsOwnLeavesEveryHopAndAVerdictAndCanBeCompared) {
  System system;
  const std::string out = (system.folder() / "a").string();
  const std::string scene = (system.folder() / "cube.toml").string();
  const Ended ran = hapton(system, {"latency", "--seconds", "1.5", "--out", out, "--scene", scene, "--size", "300"});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  for (const char* part :
       {"wire_out", "wire_back", "decode", "jitter", "bare_echo", "verdict at 1 kHz", "fit for 10 kHz", "same clock", "bare timer"}) {
    EXPECT_THAT(ran.out, HasSubstr(part));
  }
  const Json report = Json::parse(read_text(system.folder() / "a" / "report.json"), nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report.at("verdict").at("rate_hz"), 1000.0);
  EXPECT_EQ(report.at("verdict").at("fit_for").size(), 3U);
  EXPECT_EQ(report.at("notes").at("echo_bytes"), "300");
  // The bare timer runs before and after the measurement; each run also counts the periods after its end by which its last tick was late.
  const Json& timer = report.at("bare_timer");
  const double periods = timer.at("ticks").get<double>() + timer.at("missed").get<double>();
  EXPECT_GE(periods, 748.0);
  EXPECT_LE(periods, 752.0 + 2e-3 * timer.at("late_max_us").get<double>());
  const std::int64_t forces = count(report, "forces");
  EXPECT_GT(forces, 100);
  for (const char* hop : {"encode", "wire_out", "haptics_compute", "wire_back", "decode"})
    EXPECT_GT(report.at("hops").at(hop).at("n"), forces / 2);
  EXPECT_EQ(read_text(system.folder() / "a" / "latency.txt"), ran.out);

  // The exit code of `run` follows the verdict, whatever the verdict on this machine is.
  const std::string other = (system.folder() / "b").string();
  const Ended evaluated =
      hapton(system, {"latency", "run", "--seconds", "1", "--rate", "500", "--cpu", "-1", "--out", other, "--scene", scene});
  const Json verdict = Json::parse(read_text(system.folder() / "b" / "report.json"), nullptr, false).at("verdict");
  EXPECT_EQ(evaluated.exit_code, verdict.at("holds").get<bool>() ? 0 : 1) << evaluated.err;
  const Ended compared = hapton(system, {"latency", "compare", out, other, "--json", (system.folder() / "c.json").string()});
  EXPECT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_THAT(compared.out, AllOf(HasSubstr("round_trip"), HasSubstr("B/A")));
  EXPECT_EQ(Json::parse(read_text(system.folder() / "c.json"), nullptr, false).at("schema"), "hapton.latency-compare/1");
}

TEST(Latency, OfARunningHubCoversOnlyTheMeasuredSeconds) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  const Json before = system.wait_for_report([](const Json& now) { return has_contact(now) && count(now, "forces") > 500; });
  ASSERT_GT(count(before, "forces"), 500);
  const std::string out = (system.folder() / "h").string();
  const Ended ran = hapton(system, {"latency", "--hosts", system.hub(), "--seconds", "1", "--out", out});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("no bare echo"), HasSubstr("verdict at 1 kHz")));
  const Json report = Json::parse(read_text(system.folder() / "h" / "report.json"), nullptr, false);
  ASSERT_TRUE(report.is_object());
  // The measured second lies between two reports of the hub, which count from its start.
  const Json after = system.request_report();
  ASSERT_TRUE(after.is_object());
  for (const char* counter : {"samples", "forces", "contact_samples"}) {
    EXPECT_LE(count(report, counter), count(after, counter) - count(before, counter)) << counter;
  }
  EXPECT_GT(count(report, "forces"), 0);
  EXPECT_LE(report.at("seconds").get<double>(), after.at("seconds").get<double>() - before.at("seconds").get<double>());
  EXPECT_EQ(report.at("hops").at("round_trip").at("n").get<std::int64_t>(), count(report, "forces"));
  const Ended both = hapton(system, {"latency", "run", "--hosts", system.hub(), "--rate", "2000"});
  EXPECT_EQ(both.exit_code, 2);
  system.end_all();
}

// The figures need a quiet machine. This test checks that all programs work together, and that the force comes from patches of the scene.
TEST(BenchRemote, ComparesTheRealPrograms) {
  System system;
  const auto csv = system.folder() / "processes.csv";
  const Ended bench = hapton(system, {"bench", "remote", "--processes", "--mesh", "bumpy:500", "--round-trip", "20", "--loss", "0.1",
                                      "--method", "patch", "--csv", csv.string()});
  ASSERT_EQ(bench.exit_code, 0) << bench.err;
  const std::string text = read_text(csv);
  const std::string names = text.substr(0, text.find('\n'));
  const std::string values = text.substr(names.size() + 1);
  const auto figure = [&](const std::string& name) {
    const std::size_t column =
        static_cast<std::size_t>(std::count(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(names.find("," + name)), ','));
    std::size_t at = 0;
    for (std::size_t i = 0; i <= column; ++i) at = values.find(',', at) + 1;
    return std::stod(values.substr(at));
  };
  EXPECT_GT(figure("contact_s"), 2.0);
  EXPECT_GT(figure("local_share"), 0.9);
  EXPECT_GT(figure("scene_kb"), 1.0);
  EXPECT_LT(figure("simulated_force_error_rms"), 1e-3);

  const Ended rejected = hapton(system, {"bench", "remote", "--processes", "--method", "deadband"});
  EXPECT_EQ(rejected.exit_code, 1);
  EXPECT_THAT(rejected.err, HasSubstr("--method deadband: no program implements it"));
}

}  // namespace
}  // namespace hapton::process
