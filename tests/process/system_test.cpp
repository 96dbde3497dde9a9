// The three nodes as people start them, over loopback: joining in any order, dying, coming back, while the others go on.
// What is asked of them is logic; times are only bounds for a busy machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "link/hub_client.h"
#include "link/link_key.h"
#include "link/sealed_client.h"
#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/process/program.h"

namespace hapton::process {
namespace {

constexpr Seconds kPatience = Seconds(30);

using Json = nlohmann::json;

// A cube of 0.1 m, and a motion that is 2 mm inside its top half of the time: contact whenever the nodes are up.
void write_cube_scene(const std::filesystem::path& folder) {
  std::ofstream(folder / "cube.obj") << "v -0.05 -0.05 -0.05\nv 0.05 -0.05 -0.05\nv 0.05 0.05 -0.05\nv -0.05 0.05 -0.05\n"
                                        "v -0.05 -0.05 0.05\nv 0.05 -0.05 0.05\nv 0.05 0.05 0.05\nv -0.05 0.05 0.05\n"
                                        "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\n"
                                        "f 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
  std::ofstream(folder / "cube.toml") << "[[object]]\nmesh = \"cube.obj\"\nunit = \"m\"\n";
  std::ofstream(folder / "taps.csv")
      << "t_s,x_m,y_m,z_m\n0,0.01,0.02,0.06\n0.2,0.01,0.02,0.048\n0.6,0.012,0.02,0.048\n0.8,0.01,0.02,0.06\n";
}

// A folder, a port and the programs that meet there.
class System {
 public:
  explicit System(std::vector<std::string> io_options = {}) : io_options_(std::move(io_options)) { write_cube_scene(folder_.path()); }

  void start(const std::string& name) {
    if (name == "vision_node" && !display_) display_ = std::make_unique<VirtualDisplay>();
    programs_[name] = std::make_unique<Program>(name, arguments_of(name), folder_.path(), display_ ? display_->name() : "");
  }
  Program& operator[](const std::string& name) { return *programs_.at(name); }

  // Another of them, beside the one there is.
  std::unique_ptr<Program> start_another(const std::string& name) {
    return std::make_unique<Program>(name, arguments_of(name), folder_.path(), display_ ? display_->name() : "");
  }

  // Asks the I/O node for its report so far; null when none comes.
  Json ask_for_report() {
    // Earlier than this the signal would end it.
    wait_until([&] { return (*this)["io_node"].out().starts_with("hub on ") || !(*this)["io_node"].is_running(); });
    std::filesystem::remove(report_path());
    (*this)["io_node"].send_signal(SIGUSR1);
    wait_until([&] { return std::filesystem::exists(report_path()) || !(*this)["io_node"].is_running(); });
    return read_report();
  }
  Json read_report() const { return Json::parse(read_text(report_path()), nullptr, false); }

  // Until what is asked of the report holds; the report that did, or the last one.
  Json wait_for_report(const std::function<bool(const Json&)>& holds) {
    Json report;
    wait_until([&] {
      report = ask_for_report();
      return report.is_object() && holds(report);
    });
    return report;
  }

  // Ends a program as a person does, and expects it to end well.
  void end(const std::string& name) {
    (*this)[name].send_signal(SIGTERM);
    const auto ended = (*this)[name].wait(kPatience);
    ASSERT_TRUE(ended) << name << " does not end";
    EXPECT_EQ(ended->exit_code, 0) << name << ":\n" << ended->out << ended->err;
  }
  void end_all() {
    for (const auto& [name, unused] : programs_) end(name);
  }

  template <class Condition>
  static bool wait_until(Condition&& holds) {
    SteadyClock clock;
    const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * kPatience.count());
    while (!holds()) {
      if (clock.now_ns() > end_ns) return false;
      clock.sleep_until_ns(clock.now_ns() + 50 * kNanosecondsPerMillisecond);
    }
    return true;
  }

  const std::string& hub() const { return hub_; }
  // The one that its programs share.
  LinkKey key() const { return *find_or_make_shared_key(folder_.path() / "hapton"); }
  const std::filesystem::path& folder() const { return folder_.path(); }
  std::filesystem::path report_path() const { return folder_.path() / "out" / "report.json"; }

 private:
  std::vector<std::string> arguments_of(const std::string& name) const {
    const std::string folder = folder_.path().string();
    if (name == "io_node") {
      std::vector<std::string> arguments = {"--bind", hub_, "--out", folder + "/out"};
      arguments.insert(arguments.end(), io_options_.begin(), io_options_.end());
      for (const char* word : {"--device", "replay", "--loop", "--trajectory"}) arguments.emplace_back(word);
      arguments.push_back(folder + "/taps.csv");
      return arguments;
    }
    std::vector<std::string> arguments = {"--hub", hub_, "--scene", folder + "/cube.toml"};
    if (name == "vision_node") arguments.insert(arguments.end(), {"--size", "320x240"});
    return arguments;
  }

  TestFolder folder_;
  std::string hub_ = "127.0.0.1:" + find_free_port();
  std::vector<std::string> io_options_;
  std::unique_ptr<VirtualDisplay> display_;
  std::map<std::string, std::unique_ptr<Program>> programs_;
};

std::int64_t count(const Json& report, const std::string& name) { return report.at("counters").at(name).get<std::int64_t>(); }

bool has_contact(const Json& report) { return count(report, "contact_samples") > 0; }
bool is_drawn(const Json& report) { return count(report, "drawn") > 0; }

// What must hold of every report, however the run went.
void expect_sane(const Json& report) {
  ASSERT_TRUE(report.is_object()) << report;
  EXPECT_EQ(report.at("schema"), "hapton.report/1");
  EXPECT_EQ(report.at("program"), "io_node");
  EXPECT_GT(report.at("seconds").get<double>(), 0.0);
  for (const auto& [name, value] : report.at("counters").items()) EXPECT_GE(value.get<std::int64_t>(), 0) << name;
  for (const char* never : {"not_finite", "duplicate", "unknown_echo", "refused_future", "bad_settings"})
    EXPECT_EQ(count(report, never), 0) << never;
  EXPECT_LE(count(report, "forces"), count(report, "states_sent"));
  EXPECT_LE(count(report, "contact_samples"), count(report, "forces"));
  for (const auto& [name, hop] : report.at("hops").items()) {
    if (hop.at("n") == 0) continue;
    double last_us = 0.0;
    for (const char* quantile : {"p50_us", "p90_us", "p99_us", "p99_9_us"}) {
      EXPECT_GE(hop.at(quantile).get<double>(), last_us) << name << " " << quantile;
      last_us = hop.at(quantile);
    }
    // A quantile is read from a bucket of 1.6 % width, the maximum is exact.
    EXPECT_LE(last_us, 1.02 * hop.at("max_us").get<double>()) << name;
  }
}

#ifdef HAPTON_WITH_VISION
const std::vector<std::string> kNodes = {"haptics_node", "io_node", "vision_node"};
bool is_complete(const Json& report) { return has_contact(report) && is_drawn(report); }
#else
const std::vector<std::string> kNodes = {"haptics_node", "io_node"};
bool is_complete(const Json& report) { return has_contact(report); }
#endif

std::vector<std::vector<std::string>> all_orders() {
  std::vector<std::vector<std::string>> orders;
  std::vector<std::string> order = kNodes;
  do {
    orders.push_back(order);
  } while (std::ranges::next_permutation(order).found);
  return orders;
}

class JoiningOrder : public ::testing::TestWithParam<std::vector<std::string>> {};

TEST_P(JoiningOrder, DoesNotMatter) {
  System system;
  SteadyClock clock;
  for (const std::string& node : GetParam()) {
    system.start(node);
    clock.sleep_until_ns(clock.now_ns() + 150 * kNanosecondsPerMillisecond);
  }
  const Json report = system.wait_for_report(is_complete);
  ASSERT_TRUE(report.is_object());
  EXPECT_TRUE(is_complete(report)) << report;
  expect_sane(report);
  system.end_all();
  expect_sane(system.read_report());
}

std::string order_name(const ::testing::TestParamInfo<std::vector<std::string>>& order) {
  std::string name;
  for (const std::string& node : order.param) name += (name.empty() ? "" : "_") + node.substr(0, node.find('_'));
  return name;
}

INSTANTIATE_TEST_SUITE_P(All, JoiningOrder, ::testing::ValuesIn(all_orders()), order_name);

TEST(SystemRun, ReportsWhatItMeasured) {
  System system({"--seconds", "2"});
  system.start("haptics_node");
  system.start("io_node");
  const auto ended = system["io_node"].wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  system.end("haptics_node");

  const Json report = system.read_report();
  expect_sane(report);
  EXPECT_GT(count(report, "contact_samples"), 0);
  EXPECT_NEAR(report.at("seconds").get<double>(), 2.0, 0.5);
  EXPECT_EQ(count(report, "samples") + count(report, "missed_cycles"), std::llround(report.at("seconds").get<double>() * 1000.0));
  // Every answered sample has one round trip.
  EXPECT_EQ(report.at("hops").at("round_trip").at("n").get<std::int64_t>(), count(report, "forces"));

  // The CSV holds the same histograms.
  std::map<std::string, std::int64_t> rows;
  std::istringstream csv(read_text(system.folder() / "out" / "latency.csv"));
  std::string line;
  ASSERT_TRUE(std::getline(csv, line));
  EXPECT_EQ(line, "hop,lower_ns,upper_ns,count");
  while (std::getline(csv, line)) rows[line.substr(0, line.find(','))] += std::stoll(line.substr(line.rfind(',') + 1));
  for (const auto& [name, hop] : report.at("hops").items()) EXPECT_EQ(rows[name], hop.at("n").get<std::int64_t>()) << name;
}

// Sits at the hub as a vision node does and sees every force that is written to the device.
class Onlooker {
 public:
  explicit Onlooker(const System& system)
      : hub_(*parse_address(system.hub())), endpoint_(*open_udp_endpoint("127.0.0.1:0")), sealed_(*endpoint_, clock_, system.key(), hub_) {}

  // The next probe state; false when none comes in time.
  bool see(ProbeState& state) {
    const std::int64_t end_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * kPatience.count());
    Datagram datagram;
    while (clock_.now_ns() < end_ns) {
      if (!client_.receive(datagram, clock_.now_ns() + 20 * kNanosecondsPerMillisecond)) continue;
      if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) {
        state = *probe;
        return true;
      }
    }
    return false;
  }

  // Sees on until a force is felt (or none any more); false when that does not come in time.
  bool see_until(bool felt, ProbeState& state) {
    const std::int64_t end_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * kPatience.count());
    while (clock_.now_ns() < end_ns && see(state)) {
      if ((state.force_n.norm() > 0.0) == felt) return true;
    }
    return false;
  }

  std::int64_t now_ns() const { return clock_.now_ns(); }

 private:
  SteadyClock clock_;
  Address hub_;
  std::unique_ptr<Endpoint> endpoint_;
  SealedClient sealed_;
  HubClient client_{sealed_, clock_, NodeRole::vision, hub_};
};

TEST(Haptics, KilledInContactLeavesNoForceAndComesBackWithIt) {
  System system({"--vision-rate", "1000"});
  system.start("io_node");
  system.start("haptics_node");
  Onlooker onlooker(system);
  ProbeState state;
  ASSERT_TRUE(onlooker.see_until(true, state)) << "no contact";

  system["haptics_node"].kill();
  const std::int64_t killed_ns = onlooker.now_ns();
  // The last force answers a sample from before this moment; 20 ms after that one there is none. As much again for a busy machine.
  const std::int64_t silent_ns = killed_ns + 40 * kNanosecondsPerMillisecond;
  int seen = 0;
  while (onlooker.see(state) && state.sample_time_ns < killed_ns + kNanosecondsPerSecond) {
    if (state.sample_time_ns < silent_ns) continue;
    ++seen;
    EXPECT_EQ(state.force_n, Vec3::Zero()) << 1e-6 * static_cast<double>(state.sample_time_ns - killed_ns) << " ms after the kill";
    EXPECT_FALSE(state.contact);
  }
  EXPECT_GT(seen, 0);

  const Json alone = system.ask_for_report();
  expect_sane(alone);
  EXPECT_GE(count(alone, "silence_events"), 1);

  system.start("haptics_node");
  ASSERT_TRUE(onlooker.see_until(true, state)) << "no contact after the restart";
  const Json again = system.ask_for_report();
  expect_sane(again);
  EXPECT_GT(count(again, "contact_samples"), count(alone, "contact_samples"));
  system.end_all();
}

TEST(Haptics, TheSecondOneWaitsUntilTheFirstIsGone) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  const auto second = system.start_another("haptics_node");
  const Json refused = system.wait_for_report([](const Json& report) { return count(report, "joins_refused") > 0; });
  EXPECT_GT(count(refused, "joins_refused"), 0);
  EXPECT_TRUE(second->is_running());
  EXPECT_TRUE(system["haptics_node"].is_running());

  system["haptics_node"].kill();
  const std::int64_t before = count(system.ask_for_report(), "contact_samples");
  const Json taken_over = system.wait_for_report([&](const Json& report) { return count(report, "contact_samples") > before + 100; });
  EXPECT_GT(count(taken_over, "contact_samples"), before + 100);
  expect_sane(taken_over);
  second->send_signal(SIGTERM);
  const auto ended = second->wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0);
  system.end("io_node");
}

TEST(Hub, KilledAndRestartedIsFoundAgainByAll) {
  System system;
  for (const std::string& node : kNodes) system.start(node);
  ASSERT_TRUE(is_complete(system.wait_for_report(is_complete)));
  system["io_node"].kill();
  system.start("io_node");
  const Json report = system.wait_for_report(is_complete);
  ASSERT_TRUE(report.is_object());
  EXPECT_TRUE(is_complete(report)) << report;
  expect_sane(report);
  system.end_all();
}

TEST(Hub, GoesOnFromOneRateToAnotherAndBetweenMethods) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  for (const char* rate : {"250", "2000"}) {
    const auto set = run("hapton", {"set", "--hub", system.hub(), "--rate", rate}, system.folder());
    ASSERT_TRUE(set);
    EXPECT_EQ(set->exit_code, 0) << set->err;
    EXPECT_EQ(system.ask_for_report().at("rates_hz").at("servo_asked"), std::stod(rate));
  }
  for (const char* method : {"reference", "sweep"}) {
    const auto set = run("hapton", {"set", "--hub", system.hub(), "--method", method}, system.folder());
    ASSERT_TRUE(set);
    EXPECT_EQ(set->exit_code, 0) << set->err;
    const std::int64_t before = count(system.ask_for_report(), "contact_samples");
    const auto goes_on = [&](const Json& report) { return count(report, "contact_samples") > before + 500; };
    EXPECT_TRUE(goes_on(system.wait_for_report(goes_on))) << method;
  }
  system.end_all();
}

#ifdef HAPTON_WITH_VISION
TEST(Vision, KilledIsMissedByNobody) {
  System system;
  for (const std::string& node : kNodes) system.start(node);
  ASSERT_TRUE(is_complete(system.wait_for_report(is_complete)));
  system["vision_node"].kill();
  const Json gone = system.wait_for_report([](const Json& report) { return count(report, "peers_timed_out") > 0; });
  EXPECT_EQ(count(gone, "peers_timed_out"), 1);
  const auto goes_on = [&](const Json& report) { return count(report, "contact_samples") > count(gone, "contact_samples") + 100; };
  EXPECT_TRUE(goes_on(system.wait_for_report(goes_on)));

  system.start("vision_node");
  const auto drawn_again = [&](const Json& report) { return count(report, "drawn") > count(gone, "drawn"); };
  const Json again = system.wait_for_report(drawn_again);
  EXPECT_TRUE(drawn_again(again)) << again;
  expect_sane(again);
  system.end_all();
}
#endif

}  // namespace
}  // namespace hapton::process
