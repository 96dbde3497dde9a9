#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace hapton {

// A stand-in for the Haply Inverse Service: it sends an inventory first, then one state for each message, over a WebSocket at 127.0.0.1.
// It serves one client at a time, in its own thread.
class HaplyService {
 public:
  // port: 0 takes any free one. initial_version: the version at the HTTP page /version; empty: this page does not exist.
  explicit HaplyService(std::uint16_t port = 0, std::string initial_version = "3.5.1.0");
  ~HaplyService();

  std::uint16_t port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  // Settings that take effect at once.
  std::atomic<bool> is_plugged{true};
  std::atomic<bool> is_calibrated{true};
  std::atomic<bool> has_grip{true};
  mutable std::atomic<int> absent_states{0};  // how many of the next states lack the arm
  std::atomic<bool> is_silent{false};         // accepts messages and never replies
  std::atomic<bool> sends_junk{false};        // replies with broken JSON
  std::atomic<bool> hangs_up{false};          // disconnects as soon as a client is connected
  std::atomic<bool> is_scaled{false};         // the session's transform has a scale of 2
  // version to transform must be set before a client connects, position_m and buttons at any time.
  std::string version;
  std::string type = "inverse3";  // type of the arm in the config
  std::string mount;              // mount of the arm in the config, as JSON; empty: none
  std::string transform;          // transform in the first state, as JSON; empty: none
  std::array<std::atomic<double>, 3> position_m{0.0, -0.12, 0.15};
  std::atomic<int> buttons{0};

  // What clients have done.
  std::array<std::atomic<double>, 3> force_n{};
  std::atomic<double> largest_force_n{0.0};
  std::atomic<std::uint64_t> messages{0};
  std::atomic<std::uint64_t> connections{0};
  std::atomic<std::uint64_t> closed_in_order{0};  // connections that ended with a close frame
  std::string first_message() const {
    const std::lock_guard lock(mutex_);
    return first_message_;
  }

 private:
  struct Listening;
  void run();
  bool await_message(int socket);
  void serve(void* socket);
  std::string state(bool with_config) const;
  void receive(const std::string& message, bool is_first);

  std::unique_ptr<Listening> listening_;
  std::uint16_t port_ = 0;
  std::atomic<bool> ends_{false};
  mutable std::atomic<bool> was_scaled_{false};
  mutable std::mutex mutex_;
  std::string first_message_;
  std::thread thread_;
};

}  // namespace hapton
