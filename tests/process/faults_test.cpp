// The rows of docs/faults.md that need whole programs: what dies, freezes, floods or is corrupted on the wire, and what the others do then.
// Time limits are generous; the exact bounds are those of tests/faults, on simulated time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <optional>
#include <random>
#include <regex>
#include <thread>

#include "link/codec.h"
#include "tests/process/system.h"
#include "tests/process/watched_force.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kStorm = {"--loss",      "0.3", "--jitter-ms", "20",   "--reorder",     "0.1",
                                         "--duplicate", "0.1", "--corrupt",   "0.05", "--burst-share", "0.05"};

// True if contact continues from now on for this many samples.
bool contact_continues(System& system, std::int64_t samples = 300) {
  const std::int64_t before = count(system.request_report(), "contact_samples");
  return waits_for(system, [&](const Json& report) { return count(report, "contact_samples") > before + samples; });
}

TEST(Network, LossJitterReorderCopiesAndCorruptionLeaveTheForceBounded) {
  System system(tight_limits("remote"));
  system.start("io_node");
  system.start_relay(kStorm);
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state)) << "no contact through the storm";
  const Watched watched = expect_within_limits(observer, 3.0, Until::force);
  EXPECT_GT(watched.states, 100);
  EXPECT_GT(watched.forces, 0);
  const Json report = system.request_report();
  expect_sane(report);
  EXPECT_GT(count(report, "rejected_forged") + count(report, "rejected_malformed") + count(report, "rejected_unknown_session") +
                count(report, "rejected_wrong_version"),
            0)
      << "corrupted datagrams are noticed";
  EXPECT_GT(count(report, "rejected_replayed"), 0) << "copies are noticed";
  for (const char* node : {"haptics_node", "relay", "io_node"}) system.end(node);
  const Json relay = Json::parse(read_text(system.relay_report_path()));
  for (const char* way : {"to_hub", "to_nodes"}) {
    for (const char* fault : {"lost", "lost_in_burst", "held_back", "duplicated", "corrupted"}) {
      EXPECT_GT(relay.at(way).at(fault).get<int>(), 0) << way << " " << fault;
    }
    EXPECT_EQ(relay.at(way).at("overflowed").get<int>(), 0);
  }
}

TEST(Network, APartitionTakesTheForceAwayAndItComesBackByItself) {
  System system(tight_limits("remote"));
  std::ofstream(system.folder() / "script.toml") << "repeat = true\n[[phase]]\nname = \"good\"\nseconds = 1.5\n"
                                                    "[[phase]]\nname = \"cut\"\nseconds = 1\npartition = true\n";
  system.start("io_node");
  system.start_relay({"--script", (system.folder() / "script.toml").string()});
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state));
  // A loaded machine alone can make a command late: the cuts themselves are counted too.
  const auto was_cut_twice = [&](const Json& report) {
    const std::string phases = system["relay"].out();
    return phases.find("phase cut") != phases.rfind("phase cut") && count(report, "command_timeouts") >= 2;
  };
  ASSERT_TRUE(waits_for(system, was_cut_twice)) << system["relay"].out();
  EXPECT_TRUE(contact_continues(system, 100)) << "no contact after the cut";
  expect_sane(system.request_report());
}

// The hand never leaves the body: the force after the restart is that of the earlier contact.
TEST(Haptics, RestartedExertsForceWithoutTheHandHavingLeft) {
  System system(tight_limits("remote"));
  std::ofstream(system.folder() / "taps.csv") << "t_s,x_m,y_m,z_m\n0,0.01,0.02,0.06\n1,0.01,0.02,0.049\n600,0.011,0.02,0.049\n";
  system.start("io_node");
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state));
  system["haptics_node"].kill();
  ASSERT_TRUE(observer.wait_for_no_force(state));
  system.start("haptics_node");
  const std::int64_t started_ns = observer.now_ns();
  ASSERT_TRUE(observer.wait_for_force(state)) << "no contact after the restart";
  std::printf("felt %.0f ms after the program was started\n", 1e-6 * static_cast<double>(observer.now_ns() - started_ns));
  EXPECT_GT(expect_within_limits(observer, 0.5, Until::force).forces, 0);
  expect_sane(system.request_report());
  system.end_all();
}

std::string note(const Json& report, const char* name) { return report.at("notes").value(name, ""); }

// The hand comes down at 11 mm/s, which is too fast here, and then stays in contact.
TEST(Safety, ALatchedFaultIsRecordedAndHoldsUntilAPersonResetsIt) {
  // For ten seconds after a flight record, such as that of a machine that stopped, there is no other: then the test tries again.
  std::optional<System> latching;
  Json latched;
  for (int attempt = 0; attempt < 3; ++attempt) {
    latching.emplace(std::vector<std::string>{"--max-speed", "0.008", "--vision-rate", "1000"});
    std::ofstream(latching->folder() / "taps.csv") << "t_s,x_m,y_m,z_m\n0,0.01,0.02,0.06\n1,0.01,0.02,0.049\n600,0.011,0.02,0.049\n";
    latching->start("io_node");
    latching->start("haptics_node");
    latched = latching->wait_for_report(
        [](const Json& report) { return note(report, "safety_fault") == "speed" && count(report, "contact_samples") > 300; });
    ASSERT_EQ(note(latched, "safety_fault"), "speed");
    if ((*latching)["io_node"].err().find("its last 2 s are in") == std::string::npos ||
        (*latching)["io_node"].err().find("-speed.hapton") != std::string::npos)
      break;
  }
  System& system = *latching;
  EXPECT_EQ(note(latched, "governor"), "latched");
  EXPECT_EQ(latched.at("notes").at("max_force_written_n"), "0.000");
  ASSERT_TRUE(System::wait_until([&] { return system["io_node"].err().find("-speed.hapton") != std::string::npos; }));
  const auto top = run("hapton", {"top", "--once", "--hub", system.hub()}, system.folder());
  ASSERT_TRUE(top);
  EXPECT_THAT(top->out, HasSubstr("safety governor latched: the device moved faster than its limit"));
  EXPECT_THAT(system["io_node"].err(), HasSubstr("hapton set --reset-faults"));

  const auto reset = run("hapton", {"set", "--hub", system.hub(), "--reset-faults"}, system.folder());
  ASSERT_TRUE(reset);
  EXPECT_EQ(reset->exit_code, 0) << reset->err;
  EXPECT_THAT(reset->out, HasSubstr("no fault is latched"));
  SessionObserver observer(system);
  ProbeState state;
  EXPECT_TRUE(observer.wait_for_force(state)) << "no force after the reset";
  EXPECT_EQ(count(system.request_report(), "faults_reset"), 1);
  expect_sane(system.request_report());
  system.end_all();
}

TEST(Haptics, FrozenLeavesNoForceAndThawedBringsItBackSlowly) {
  System system(tight_limits("remote"));
  system.start("io_node");
  system.start("haptics_node");
  SessionObserver observer(system);
  ProbeState state;
  ASSERT_TRUE(observer.wait_for_force(state));
  system["haptics_node"].send_signal(SIGSTOP);
  ASSERT_TRUE(waits_for(system, [](const Json& report) { return count(report, "peers_timed_out") > 0; }));
  ASSERT_TRUE(observer.wait_for_no_force(state));
  system["haptics_node"].send_signal(SIGCONT);
  const Watched watched = expect_within_limits(observer, 1.5);
  EXPECT_GT(watched.states, 0);
  EXPECT_TRUE(contact_continues(system));
  expect_sane(system.request_report());
  system.end_all();
}

TEST(Hub, FrozenAndThawedIsFoundAgainByAll) {
  System system;
  for (const std::string& node : kNodes) system.start(node);
  ASSERT_TRUE(is_complete(system.wait_for_report(is_complete)));
  SteadyClock clock;
  system["io_node"].send_signal(SIGSTOP);
  clock.sleep_until_ns(clock.now_ns() + 1500 * kNanosecondsPerMillisecond);
  for (const std::string& node : kNodes) EXPECT_TRUE(system[node].is_running()) << node;
  system["io_node"].send_signal(SIGCONT);
  EXPECT_TRUE(contact_continues(system));
  const std::int64_t drawn = count(system.request_report(), "drawn");
  EXPECT_TRUE(waits_for(system, [&](const Json& report) { return count(report, "drawn") > drawn || kNodes.size() == 2; }));
  expect_sane(system.request_report());
  system.end_all();
}

TEST(Hub, ASecondDeviceAtTheSameAddressIsRejectedInALineAndTheFirstGoesOn) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  const auto second = system.start_another("io_node");
  const auto ended = second->wait(kPatience);
  ASSERT_TRUE(ended) << "the second one runs";
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_THAT(ended->err, HasSubstr("another program holds this port"));
  EXPECT_TRUE(contact_continues(system));
  system.end_all();
}

// Sends unrequested datagrams to the hub.
class UnknownPeer {
 public:
  explicit UnknownPeer(const std::string& hub) : hub_(*parse_address(hub)), endpoint_(*open_udp_endpoint("127.0.0.1:0")) {}

  bool send(std::span<const std::byte> bytes) { return endpoint_->send(hub_, bytes); }
  // The size of the first reply within this time; 0: no reply.
  std::size_t receive_for(std::int64_t for_ns) {
    std::array<std::byte, kMaxDatagramBytes> buffer;
    return endpoint_->receive(buffer, clock_.now_ns() + for_ns).bytes;
  }

 private:
  SteadyClock clock_;
  Address hub_;
  std::unique_ptr<Endpoint> endpoint_;
};

TEST(Hub, AnotherVersionGetsNoReplyAndIsCounted) {
  System system;
  system.start("io_node");
  system.request_report();
  UnknownPeer unknown(system.hub());
  std::array<std::byte, kMaxDatagramBytes> bytes = {};
  const std::size_t size = Codec().encode({{0, 77, 1, 1}, Hello{NodeRole::haptics}}, bytes);
  for (const std::uint32_t version : {0U, 1U, kProtocolVersion + 1}) {
    bytes[1] = static_cast<std::byte>(version);
    ASSERT_TRUE(unknown.send(std::span(bytes).first(size)));
  }
  EXPECT_TRUE(waits_for(system, [](const Json& report) { return count(report, "rejected_wrong_version") == 3; }));
  EXPECT_EQ(unknown.receive_for(100 * kNanosecondsPerMillisecond), 0U);
  system.end("io_node");
}

// Sends junk datagrams at the requested rate per second, or as fast as this machine can, from one socket, many in each system call.
class Flood {
 public:
  Flood(const std::string& to, double per_second) : thread_([this, to, per_second] { run(*parse_address(to), per_second); }) {}
  ~Flood() { stop(); }
  // Stops. Returns how many datagrams were sent in a second.
  double stop() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
    return rate_;
  }

 private:
  static constexpr std::size_t kKinds = 64;
  using Junk = std::array<std::array<std::uint8_t, 200>, kKinds>;

  // Random bytes; every second datagram has the right first bytes of a message and zeros. run() gives some the length of a handshake.
  static void fill(Junk& junk) {
    std::mt19937_64 random(3);
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      for (std::uint8_t& byte : junk[kind]) byte = static_cast<std::uint8_t>(random());
      if (kind % 2 == 0) junk[kind] = {0x08, kProtocolVersion, static_cast<std::uint8_t>(kind / 2 % 5), 0};
    }
  }

  void run(const Address& to, double per_second) {
    Junk junk;
    fill(junk);
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(to.port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    std::array<iovec, kKinds> parts;
    std::array<mmsghdr, kKinds> messages = {};
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      parts[kind] = {junk[kind].data(), kind % 3 == 0 ? 68U : 10U + 3U * kind % 190U};
      messages[kind].msg_hdr = {&address, sizeof address, &parts[kind], 1, nullptr, 0, 0};
    }
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    SteadyClock clock;
    const std::int64_t start_ns = clock.now_ns();
    double sent = 0.0;
    while (!ends_) {
      clock.sleep_until_ns(start_ns + static_cast<std::int64_t>(1e9 * sent / per_second));
      const int now = ::sendmmsg(socket, messages.data(), kKinds, 0);
      if (now > 0) sent += now;
    }
    rate_ = 1e9 * sent / static_cast<double>(clock.now_ns() - start_ns);
    ::close(socket);
  }

  std::atomic<bool> ends_{false};
  double rate_ = 0.0;
  std::thread thread_;
};

// A hub under a sanitizer is some ten times as slow as one that people run.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double kFloodPerSecond = 10'000;
#else
constexpr double kFloodPerSecond = 100'000;
#endif

TEST(Hub, AFloodOfJunkDoesNotEndTheSession) {
  System system;
  system.start("io_node");
  system.start("haptics_node");
  ASSERT_TRUE(has_contact(system.wait_for_report(has_contact)));
  const auto begin = std::chrono::steady_clock::now();
  Flood flood(system.hub(), 0.5 * kFloodPerSecond);
  Flood other(system.hub(), 0.5 * kFloodPerSecond);
  EXPECT_TRUE(contact_continues(system, 1000)) << "no contact in the flood";
  const std::regex kFloodLine("flood of [a-z ]+ from 127\\.0\\.0\\.1:[0-9]+( and others)?, [0-9]+ a second");
  EXPECT_TRUE(System::wait_until([&] { return std::regex_search(system["io_node"].err(), kFloodLine); })) << system["io_node"].err();
  const Json report = system.request_report();
  std::printf("junk: %.0f datagrams a second; %ld of %ld forces lost, %ld late, %ld command timeouts\n", flood.stop() + other.stop(),
              count(report, "lost"), count(report, "samples"), count(report, "late"), count(report, "command_timeouts"));
  // The hub names the flood at most once a second.
  const std::string text = system["io_node"].err();
  const auto lines = std::distance(std::sregex_iterator(text.begin(), text.end(), kFloodLine), std::sregex_iterator());
  EXPECT_LE(lines, 1 + std::chrono::ceil<std::chrono::seconds>(std::chrono::steady_clock::now() - begin).count()) << text;
  expect_sane(report);
  EXPECT_GT(count(report, "rejected_malformed") + count(report, "rejected_wrong_version") + count(report, "rejected_wrong_key") +
                count(report, "rejected_unknown_session") + count(report, "dropped_by_kernel"),
            kFloodPerSecond / 10);
  EXPECT_EQ(count(report, "joins_rejected"), 0);
  system.end_all();
}

#ifdef HAPTON_WITH_VISION
TEST(Vision, FrozenOrFloodedChangesNoForce) {
  System system;
  const std::string at = "127.0.0.1:" + find_free_port();
  system.add_arguments("vision_node", {"--bind", at});
  for (const std::string& node : kNodes) system.start(node);
  ASSERT_TRUE(is_complete(system.wait_for_report(is_complete)));

  system["vision_node"].send_signal(SIGSTOP);
  ASSERT_TRUE(waits_for(system, [](const Json& report) { return count(report, "peers_timed_out") > 0; }));
  EXPECT_TRUE(contact_continues(system));
  system["vision_node"].send_signal(SIGCONT);
  const std::int64_t drawn_while_frozen = count(system.request_report(), "drawn");
  EXPECT_TRUE(waits_for(system, [&](const Json& report) { return count(report, "drawn") > drawn_while_frozen; }))
      << "it does not draw again";

  Flood flood(at, 20'000);
  EXPECT_TRUE(contact_continues(system, 1000));
  flood.stop();
  const std::int64_t drawn_after_flood = count(system.request_report(), "drawn");
  EXPECT_TRUE(waits_for(system, [&](const Json& report) { return count(report, "drawn") > drawn_after_flood; }));
  expect_sane(system.request_report());
  system.end_all();
}
#endif

}  // namespace
}  // namespace hapton::process
