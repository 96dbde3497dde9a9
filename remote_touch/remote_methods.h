#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/force/force_method.h"
#include "patch/tile_partition.h"
#include "remote_touch/remote_deadband.h"
#include "remote_touch/remote_touch.h"

namespace hapton {

// A method of touch across a network, and the stages between its force and the motors.
struct RemoteMethod {
  // From what the force is computed beside the device: the whole scene; nothing, because the force itself is sent; a plane that is sent
  // with each reply; the last force or its extrapolation (deadband coding); a part of the scene.
  enum class Scheme : std::uint8_t { whole, force, plane, deadband, patch };

  std::string_view name;
  std::string_view title;
  Scheme scheme = Scheme::whole;
  Prediction prediction = Prediction::hold;  // used by deadband coding
  bool has_governor = false;                 // the governor of io_node, which releases a force 20 ms after its sample
  bool is_passive = false;                   // has the passivity controller
};

// local, remote, remote-held, remote-passive, plane, deadband, deadband-linear, patch, patch-passive. RT: yes.
std::span<const RemoteMethod> remote_methods() noexcept;
// Null if no method has that name. RT: yes.
const RemoteMethod* find_remote_method(std::string_view name) noexcept;
// "local, remote, ..." for help texts. RT: set-up only.
std::string remote_method_names();

// A scene to be touched, made once for many runs, one after the other: each begins with a reset. Frames: S and W are one.
struct RemoteScene {
  std::shared_ptr<const TriangleMesh> mesh;
  double stiffness_n_per_m = 0.0;
  // The same method twice, since each run of both at the same time needs a proxy of its own.
  std::shared_ptr<ForceMethod> measured_method;    // of the RemoteMethod that is measured, at the haptics node or beside the device
  std::shared_ptr<ForceMethod> zero_delay_method;  // computes the force without delay, with which it is compared
  TiledScene tiles;
};
Result<RemoteScene> make_remote_scene(std::shared_ptr<const TriangleMesh> mesh, const Material& material);

// Settings of deadband coding, and of the methods that send parts of the scene.
struct RemoteSettings {
  double deadband = 0.1;  // Weber's fraction
  double patch_bits_per_s = 1e6;
};

// RT: no.
std::unique_ptr<RemoteTouch> make_remote_touch(const RemoteMethod& method, const RemoteScene& scene, const RemoteNetwork& network,
                                               const RemoteSettings& settings);

}  // namespace hapton
