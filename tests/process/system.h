#pragma once

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
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

using Json = nlohmann::json;

// A folder, a port and the programs that use them. The device is a replay of taps on a cube, unless io_options name another.
class System {
 public:
  explicit System(std::vector<std::string> io_options = {});

  void start(const std::string& name) {
    if (name == "vision_node" && !display_) display_ = std::make_unique<VirtualDisplay>();
    programs_[name] = std::make_unique<Program>(name, arguments_of(name), folder_.path(), display_ ? display_->name() : "");
  }
  Program& operator[](const std::string& name) { return *programs_.at(name); }

  // Starts one more program of this name beside the running one.
  std::unique_ptr<Program> start_another(const std::string& name) {
    return std::make_unique<Program>(name, arguments_of(name), folder_.path(), display_ ? display_->name() : "");
  }

  // Puts `hapton relay` with these faults between the hub and the nodes that are started from now on.
  void start_relay(const std::vector<std::string>& faults) {
    nodes_hub_ = "127.0.0.1:" + find_free_port();
    std::vector<std::string> arguments = {
        "relay", "--listen", nodes_hub_, "--hub", hub_, "--seed", "7", "--json", relay_report_path().string()};
    arguments.insert(arguments.end(), faults.begin(), faults.end());
    programs_["relay"] = std::make_unique<Program>("hapton", arguments, folder_.path());
    wait_until([&] { return programs_["relay"]->out().starts_with("relay at ") || !programs_["relay"]->is_running(); });
  }
  std::filesystem::path relay_report_path() const { return folder_.path() / "relay.json"; }

  // Arguments that are added to those of a program that is started from now on.
  void add_arguments(const std::string& name, const std::vector<std::string>& arguments) { extra_arguments_[name] = arguments; }

  // Requests the I/O node's report so far; null if none comes.
  Json request_report() {
    // Before io_node prints this line, the signal would end it.
    wait_until([&] { return (*this)["io_node"].out().starts_with("hub on ") || !(*this)["io_node"].is_running(); });
    std::filesystem::remove(report_path());
    (*this)["io_node"].send_signal(SIGUSR1);
    wait_until([&] { return std::filesystem::exists(report_path()) || !(*this)["io_node"].is_running(); });
    return read_report();
  }
  Json read_report() const { return Json::parse(read_text(report_path()), nullptr, false); }

  // Waits until the condition on the report holds; returns that report, or the last one.
  Json wait_for_report(const std::function<bool(const Json&)>& holds) {
    Json report;
    wait_until([&] {
      report = request_report();
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
  static bool wait_until(Condition&& holds, Seconds at_most = kPatience) {
    SteadyClock clock;
    const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * at_most.count());
    while (!holds()) {
      if (clock.now_ns() > end_ns) return false;
      clock.sleep_until_ns(clock.now_ns() + 50 * kNanosecondsPerMillisecond);
    }
    return true;
  }

  const std::string& hub() const { return hub_; }
  // The key that the programs of this system share.
  LinkKey key() const { return *find_or_make_shared_key(folder_.path() / "hapton"); }
  const std::filesystem::path& folder() const { return folder_.path(); }
  std::filesystem::path report_path() const { return folder_.path() / "out" / "report.json"; }

 private:
  std::vector<std::string> arguments_of(const std::string& name) const {
    const std::string folder = folder_.path().string();
    if (name == "io_node") {
      std::vector<std::string> arguments = {"--bind", hub_, "--out", folder + "/out"};
      arguments.insert(arguments.end(), io_options_.begin(), io_options_.end());
      if (std::find(io_options_.begin(), io_options_.end(), "--device") != io_options_.end())
        return with_extra_arguments(name, std::move(arguments));
      for (const char* word : {"--device", "replay", "--loop", "--trajectory"}) arguments.emplace_back(word);
      arguments.push_back(folder + "/taps.csv");
      return with_extra_arguments(name, std::move(arguments));
    }
    std::vector<std::string> arguments = {"--hub", nodes_hub_, "--scene", folder + "/cube.toml"};
    if (name == "vision_node") arguments.insert(arguments.end(), {"--size", "320x240"});
    return with_extra_arguments(name, std::move(arguments));
  }

  std::vector<std::string> with_extra_arguments(const std::string& name, std::vector<std::string> arguments) const {
    if (const auto more = extra_arguments_.find(name); more != extra_arguments_.end())
      arguments.insert(arguments.end(), more->second.begin(), more->second.end());
    return arguments;
  }

  TestFolder folder_;
  std::string hub_ = "127.0.0.1:" + find_free_port();
  std::string nodes_hub_ = hub_;  // where the nodes look for the hub
  std::vector<std::string> io_options_;
  std::map<std::string, std::vector<std::string>> extra_arguments_;
  std::unique_ptr<VirtualDisplay> display_;
  std::map<std::string, std::unique_ptr<Program>> programs_;
};

std::int64_t count(const Json& report, const std::string& name);

bool has_contact(const Json& report);
bool is_drawn(const Json& report);

// Checks what is true of every report, however the run went.
void expect_sane(const Json& report);

// All nodes that are built, and whether a report shows all of them at work.
extern const std::vector<std::string> kNodes;
bool is_complete(const Json& report);

// Joins the hub like a vision node that draws at once, and so gets the force as often as possible.
class SessionObserver {
 public:
  explicit SessionObserver(const System& system)
      : hub_(*parse_address(system.hub())),
        endpoint_(*open_udp_endpoint("127.0.0.1:0")),
        sealed_(*endpoint_, clock_, RoleKey(system.key(), KeyRole::vision), hub_) {}

  // The next probe state; false when none comes in time.
  bool receive_state(ProbeState& state) {
    const std::int64_t end_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * kPatience.count());
    Datagram datagram;
    while (clock_.now_ns() < end_ns) {
      if (!client_.receive(datagram, clock_.now_ns() + 20 * kNanosecondsPerMillisecond)) continue;
      if (const auto* pose = std::get_if<ObjectPose>(&datagram.message)) object_pose_ = *pose;
      if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) {
        state = *probe;
        sent_ns_ = datagram.header.send_time_ns;
        client_.send(FrameAck{.echo_sample = probe->sample,
                              .echo_sample_time_ns = probe->sample_time_ns,
                              .frame_rate_hz = 60.0F,
                              .every_sample = hand_target_.active});
        if (hand_target_.active) client_.send(hand_target_);
        return true;
      }
    }
    return false;
  }

  // Receive until there is a force, or none; false if that does not happen in time.
  bool wait_for_force(ProbeState& state) { return receive_until(true, state); }
  bool wait_for_no_force(ProbeState& state) { return receive_until(false, state); }

  // Leads the hand of a simulated device to p_WH; it stays there until the next call.
  void lead_hand(const Vec3& p_WH, std::uint32_t buttons = 0) { hand_target_ = {.active = true, .p_WH = p_WH, .buttons = buttons}; }
  void send(const Message& message) { client_.send(message); }
  // The newest pose that was received, of any object.
  const ObjectPose& object_pose() const { return object_pose_; }

  std::int64_t now_ns() const { return clock_.now_ns(); }
  std::int64_t sent_ns() const { return sent_ns_; }  // when the hub sent the last probe state that was received

 private:
  bool receive_until(bool has_force, ProbeState& state) {
    const std::int64_t end_ns = clock_.now_ns() + static_cast<std::int64_t>(1e9 * kPatience.count());
    while (clock_.now_ns() < end_ns && receive_state(state)) {
      if ((state.force_n.norm() > 0.0) == has_force) return true;
    }
    return false;
  }

  SteadyClock clock_;
  Address hub_;
  std::unique_ptr<Endpoint> endpoint_;
  SealedClient sealed_;
  HubClient client_{sealed_, clock_, NodeRole::vision, hub_};
  std::int64_t sent_ns_ = 0;
  HandTarget hand_target_;
  ObjectPose object_pose_;
};

}  // namespace hapton::process
