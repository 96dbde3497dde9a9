#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/process/program.h"
#include "tests/support/motor_observer.h"
#include "tests/support/scratch_folder.h"

namespace hapton::attack {

// io_node with a simulated device under the limits of its unit, a haptics node, and an observer of the motors.
class TestBed {
 public:
  // A fault is made only once a force of at least this size is on the motors.
  static constexpr double kForceN = 0.3;

  // touch: value of io_node --touch.
  explicit TestBed(const std::string& touch = "auto");

  // Waits until a force is on the motors, with --touch patch one from patches. Returns "", or a line that says what did not start or come.
  std::string await_contact();

  process::Program& io() { return *io_; }
  process::Program& haptics() { return *haptics_; }
  MotorObserver& observer() { return observer_; }
  const std::string& hub() const { return hub_; }
  const std::filesystem::path& folder() const { return folder_.path(); }
  // Where the haptics node sends from, as io_node saw it; "" before it has joined.
  std::string haptics_address() const;
  // Records a handshake and data of a tool that holds the key, as an eavesdropper could. Returns the file; "": nothing was recorded.
  std::string capture();
  // A report of io_node as of now; null: none came.
  nlohmann::json request_report();

 private:
  bool has_patches();

  ScratchFolder folder_;
  std::string touch_;
  std::string hub_ = "127.0.0.1:" + process::find_free_port();
  std::unique_ptr<process::Program> io_;
  std::unique_ptr<process::Program> haptics_;
  MotorObserver observer_;
};

// Waits until the condition holds; false: not within 30 s.
bool wait_until(const std::function<bool()>& holds);

}  // namespace hapton::attack
