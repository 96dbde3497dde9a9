// The three nodes as users start them, over loopback: they join in any order, die and come back, while the others continue. The tests check
// logic; times are only generous bounds for a busy machine.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "tests/process/system.h"

namespace hapton::process {
namespace {

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

// Reads the number in a line such as "haptics_node: 1983 samples with a reply, ..."; -1: there is no such line.
std::int64_t read_reply_count(Program& haptics_node) {
  const std::string out = haptics_node.out();
  const std::size_t at = out.find("haptics_node: ");
  return at == std::string::npos ? -1 : std::stoll(out.substr(at + std::string("haptics_node: ").size()));
}

TEST(SystemRun, ReportsWhatItMeasured) {
  // If a busy machine took too few samples in a short run, the run is repeated with twice the length.
  std::optional<System> run;
  Json report;
  double elapsed_s = 0.0;
  double seconds = 2.0;
  for (;; seconds *= 2.0) {
    run.emplace(std::vector<std::string>{"--seconds", std::to_string(seconds)});
    run->start("haptics_node");
    const SteadyClock clock;
    const std::int64_t begin_ns = clock.now_ns();
    run->start("io_node");
    const auto ended = (*run)["io_node"].wait(Seconds(seconds) + kPatience);
    elapsed_s = 1e-9 * static_cast<double>(clock.now_ns() - begin_ns);
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->exit_code, 0) << ended->err;
    run->end("haptics_node");
    report = run->read_report();
    ASSERT_TRUE(report.is_object());
    const bool is_representative = count(report, "contact_samples") > 0 && static_cast<double>(count(report, "samples")) >= 500.0 * seconds;
    if (is_representative || seconds > 15.0) break;
  }
  System& system = *run;
  expect_sane(report);
  EXPECT_GT(count(report, "contact_samples"), 0);
  EXPECT_GE(report.at("seconds").get<double>(), seconds - 0.5);
  // Compares with independent measurements: this process measures the time, the haptics node counts the samples.
  EXPECT_LE(report.at("seconds").get<double>(), elapsed_s);
  EXPECT_LE(count(report, "samples") + count(report, "missed_cycles"), std::llround(1000.0 * elapsed_s));
  EXPECT_GE(static_cast<double>(count(report, "samples")), 500.0 * seconds)
      << "less than half of the rate: the machine is overloaded or the loop is broken";
  const std::int64_t replied = read_reply_count(system["haptics_node"]);
  EXPECT_GE(replied, count(report, "forces"));
  EXPECT_LE(replied, count(report, "states_sent"));
  EXPECT_GE(count(report, "forces"), 9 * replied / 10) << "loopback loses no force";
  // Every sample with a reply has one round trip.
  EXPECT_EQ(report.at("hops").at("round_trip").at("n").get<std::int64_t>(), count(report, "forces"));

  // The CSV has the same histograms.
  std::map<std::string, std::int64_t> rows;
  std::istringstream csv(read_text(system.folder() / "out" / "latency.csv"));
  std::string line;
  ASSERT_TRUE(std::getline(csv, line));
  EXPECT_EQ(line, "hop,lower_ns,upper_ns,count");
  while (std::getline(csv, line)) rows[line.substr(0, line.find(','))] += std::stoll(line.substr(line.rfind(',') + 1));
  for (const auto& [name, hop] : report.at("hops").items()) EXPECT_EQ(rows[name], hop.at("n").get<std::int64_t>()) << name;
}

TEST(Haptics, KilledInContactLeavesNoForceAndComesBackWithIt) {
  System system({"--vision-rate", "1000"});
  system.start("io_node");
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state)) << "no contact";

  system["haptics_node"].kill();
  const std::int64_t killed_ns = observer.now_ns();
  // The last force is for a sample before this moment, and ends 20 ms after that sample. Another 20 ms are for a busy machine.
  const std::int64_t silent_ns = killed_ns + 40 * kNanosecondsPerMillisecond;
  int checked_states = 0;
  while (observer.receive_state(state) && state.sample_time_ns < killed_ns + kNanosecondsPerSecond) {
    if (state.sample_time_ns < silent_ns) continue;
    ++checked_states;
    EXPECT_EQ(state.force_n, Vec3::Zero()) << 1e-6 * static_cast<double>(state.sample_time_ns - killed_ns) << " ms after the kill";
    EXPECT_FALSE(state.contact);
  }
  EXPECT_GT(checked_states, 0);

  const Json alone = system.request_report();
  expect_sane(alone);
  EXPECT_GE(count(alone, "command_timeouts"), 1);

  system.start("haptics_node");
  ASSERT_TRUE(observer.wait_for_force(state)) << "no contact after the restart";
  const Json again = system.request_report();
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
  const Json rejected = system.wait_for_report([](const Json& report) { return count(report, "joins_rejected") > 0; });
  EXPECT_GT(count(rejected, "joins_rejected"), 0);
  EXPECT_TRUE(second->is_running());
  EXPECT_TRUE(system["haptics_node"].is_running());

  system["haptics_node"].kill();
  const std::int64_t before = count(system.request_report(), "contact_samples");
  const Json taken_over = system.wait_for_report([&](const Json& report) { return count(report, "contact_samples") > before + 100; });
  EXPECT_GT(count(taken_over, "contact_samples"), before + 100);
  expect_sane(taken_over);
  second->send_signal(SIGTERM);
  const auto ended = second->wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 0);
  system.end("io_node");
}

TEST(Haptics, TheSecondOneSaysAtItsEndThatThereWasAnother) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  system.add_arguments("haptics_node", {"--seconds", "3"});
  // If the first node stands still, the second one rightly takes over; then the test tries again.
  std::optional<Ended> ended;
  for (int attempt = 0; attempt < 5; ++attempt) {
    ended = system.start_another("haptics_node")->wait(kPatience);
    ASSERT_TRUE(ended);
    if (ended->exit_code == 1) break;
    ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  }
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_NE(ended->err.find("had another haptics node for all of 3 s; end that one"), std::string::npos) << ended->err;
  system.end_all();
}

TEST(Hub, ThatEndsInOrderIsNoWarningAtTheOthers) {
  System system;
  for (const std::string& node : kNodes) system.start(node);
  ASSERT_TRUE(is_complete(system.wait_for_report(is_complete)));
  // Only what the nodes print from here on counts: they may have missed a hub that stood still for a moment before.
  std::map<std::string, std::size_t> printed_bytes;
  for (const std::string& node : kNodes) printed_bytes[node] = system[node].err().size();
  system.end("io_node");
  for (const std::string& node : kNodes) {
    if (node == "io_node") continue;
    const auto says = [&](const char* what) { return system[node].err().find(what, printed_bytes[node]) != std::string::npos; };
    EXPECT_TRUE(System::wait_until([&] { return says("the hub has ended its session"); })) << node << "\n" << system[node].err();
    EXPECT_FALSE(says("stopped replying")) << system[node].err();
    system.end(node);
  }
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
    EXPECT_EQ(system.request_report().at("rates_hz").at("servo_requested"), std::stod(rate));
  }
  for (const char* method : {"reference", "sweep"}) {
    const auto set = run("hapton", {"set", "--hub", system.hub(), "--method", method}, system.folder());
    ASSERT_TRUE(set);
    EXPECT_EQ(set->exit_code, 0) << set->err;
    const std::int64_t before = count(system.request_report(), "contact_samples");
    const auto goes_on = [&](const Json& report) { return count(report, "contact_samples") > before + 500; };
    EXPECT_TRUE(goes_on(system.wait_for_report(goes_on))) << method;
  }
  system.end_all();
}

TEST(Haptics, AnUnusableMethodIsRejectedWithItsReasonAtTheRequester) {
  System system;
  system.add_arguments("haptics_node", {"--probe-radius", "0.001"});
  const auto set = [&](const char* method) { return run("hapton", {"set", "--hub", system.hub(), "--method", method}, system.folder()); };
  system.start("io_node");
  System::wait_until([&] { return system["io_node"].out().starts_with("hub on "); });
  const auto alone = set("reference");
  ASSERT_TRUE(alone);
  EXPECT_EQ(alone->exit_code, 1);
  EXPECT_NE(alone->err.find("no haptics node"), std::string::npos) << alone->err;

  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  for (const char* method : {"smooth", "sweep"}) {
    const auto rejected = set(method);
    ASSERT_TRUE(rejected);
    EXPECT_EQ(rejected->exit_code, 1) << method;
    EXPECT_NE(rejected->err.find("radius"), std::string::npos) << rejected->err;
    EXPECT_EQ(std::count(rejected->err.begin(), rejected->err.end(), '\n'), 1) << rejected->err;
  }
  const auto accepted = set("reference");
  ASSERT_TRUE(accepted);
  EXPECT_EQ(accepted->exit_code, 0) << accepted->err;
  EXPECT_NE(accepted->out.find("method reference in use"), std::string::npos) << accepted->out;
  system.end_all();
}

#ifdef HAPTON_WITH_VISION
TEST(Vision, KilledDisturbsNoOtherNode) {
  System system;
  for (const std::string& node : kNodes) system.start(node);
  const Json whole = system.wait_for_report(is_complete);
  ASSERT_TRUE(is_complete(whole));
  system["vision_node"].kill();
  // On a machine that is too busy, other nodes may time out for a moment as well.
  const auto has_timed_out = [&](const Json& report) { return count(report, "peers_timed_out") > count(whole, "peers_timed_out"); };
  const Json gone = system.wait_for_report(has_timed_out);
  EXPECT_TRUE(has_timed_out(gone));
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
