#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/process/system.h"

namespace hapton::dds_test {

// The DDS names of ROS 2 message types.
inline const std::string kPose = "geometry_msgs::msg::dds_::PoseStamped_";
inline const std::string kTwist = "geometry_msgs::msg::dds_::TwistStamped_";
inline const std::string kWrench = "geometry_msgs::msg::dds_::WrenchStamped_";
inline const std::string kJoy = "sensor_msgs::msg::dds_::Joy_";
inline const std::string kTransforms = "tf2_msgs::msg::dds_::TFMessage_";

// A DDS domain that no other run of these tests on this host uses until this program ends; its ports are below those that the system gives
// out.
int domain();

// `hapton dds` beside a system's nodes, in domain(). Threads: one.
class Bridge {
 public:
  // interface: if empty, --interface is not given.
  explicit Bridge(const process::System& system, const std::vector<std::string>& more = {}, const std::string& interface = "127.0.0.1")
      : Bridge(system.hub(), system.folder(), more, interface) {}
  // folder: contains the key as hapton/key.
  Bridge(const std::string& hub, const std::filesystem::path& folder, const std::vector<std::string>& more, const std::string& interface);

  bool is_publishing();
  // Ends the program as Ctrl-C does and expects exit code 0. Returns its standard output.
  std::string end();
  // Ends the program as a crash does.
  void kill() { program_->kill(); }
  std::string out() const { return program_->out(); }
  std::string err() const { return program_->err(); }

 private:
  std::unique_ptr<process::Program> program_;
};

}  // namespace hapton::dds_test
