#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace hapton {

// A stand-in for the Haply Inverse Service: an inventory first, then one state for each message, over a WebSocket of 127.0.0.1. One client
// at a time, in its own thread.
class HaplyService {
 public:
  // port 0: any free one. version_in: at /version; empty: there is no such page.
  explicit HaplyService(std::uint16_t port = 0, std::string version_in = "3.5.1.0");
  ~HaplyService();

  std::uint16_t port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  // Its behaviour from now on.
  std::atomic<bool> is_plugged{true};
  std::atomic<bool> is_calibrated{true};
  std::atomic<bool> has_grip{true};
  mutable std::atomic<int> absent_states{0};  // so many next states are without the arm
  std::atomic<bool> is_silent{false};         // accepts messages and never replies
  std::atomic<bool> sends_junk{false};        // replies with something else
  std::atomic<bool> hangs_up{false};          // as soon as a client is connected
  std::atomic<bool> is_scaled{false};         // its session's transform has a scale
  // Before a client connects.
  std::string version;
  std::string type = "inverse3";  // of its config
  std::string mount;              // of its config, JSON; empty: none
  std::string transform;          // of its first state, JSON
  std::array<std::atomic<double>, 3> position_m{0.0, -0.12, 0.15};
  std::atomic<int> buttons{0};

  // What was done to it.
  std::array<std::atomic<double>, 3> force_n{};
  std::atomic<double> largest_force_n{0.0};
  std::atomic<std::uint64_t> messages{0};
  std::atomic<std::uint64_t> connections{0};
  std::atomic<std::uint64_t> closed_in_order{0};  // by a close frame
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
