#include "remote_touch/remote_methods.h"

#include <algorithm>
#include <array>
#include <utility>

#include "remote_touch/remote_force.h"
#include "remote_touch/remote_patch.h"
#include "remote_touch/remote_plane.h"
#include "remote_touch/whole_scene.h"

namespace hapton {
namespace {

using Scheme = RemoteMethod::Scheme;

constexpr std::array<RemoteMethod, 9> kMethods = {{
    {.name = "local", .title = "whole scene beside the device: zero delay", .scheme = Scheme::whole},
    {.name = "remote",
     .title = "remote force as io_node uses it: released 20 ms after its sample",
     .scheme = Scheme::force,
     .has_governor = true},
    {.name = "remote-held", .title = "remote force, the newest one held indefinitely", .scheme = Scheme::force},
    {.name = "remote-passive", .title = "remote force held, and the passivity controller", .scheme = Scheme::force, .is_passive = true},
    {.name = "plane", .title = "one plane, a new one with each reply", .scheme = Scheme::plane},
    {.name = "deadband", .title = "deadband coding, the last force held", .scheme = Scheme::deadband},
    {.name = "deadband-linear",
     .title = "deadband coding, linear prediction",
     .scheme = Scheme::deadband,
     .prediction = Prediction::linear},
    {.name = "patch", .title = "parts of the scene beside the device", .scheme = Scheme::patch},
    {.name = "patch-passive",
     .title = "parts of the scene, governor and passivity controller",
     .scheme = Scheme::patch,
     .has_governor = true,
     .is_passive = true},
}};

}  // namespace

std::span<const RemoteMethod> remote_methods() noexcept { return kMethods; }

const RemoteMethod* find_remote_method(std::string_view name) noexcept {
  const auto found = std::find_if(kMethods.begin(), kMethods.end(), [&](const RemoteMethod& method) { return method.name == name; });
  return found == kMethods.end() ? nullptr : &*found;
}

std::string remote_method_names() {
  std::string names;
  for (const RemoteMethod& method : kMethods) names += (names.empty() ? "" : ", ") + std::string(method.name);
  return names;
}

Result<RemoteScene> make_remote_scene(std::shared_ptr<const TriangleMesh> mesh, const Material& material) {
  TouchScene scene;
  scene.objects.push_back({mesh, material});
  auto measured_method = make_method({}, scene);
  if (!measured_method) return tl::unexpected(measured_method.error());
  auto zero_delay_method = make_method({}, scene);
  if (!zero_delay_method) return tl::unexpected(zero_delay_method.error());
  return RemoteScene{std::move(mesh), material.stiffness_n_per_m, std::move(*measured_method), std::move(*zero_delay_method),
                     make_tiles(scene)};
}

std::unique_ptr<RemoteTouch> make_remote_touch(const RemoteMethod& method, const RemoteScene& scene, const RemoteNetwork& network,
                                               const RemoteSettings& settings) {
  switch (method.scheme) {
    case Scheme::whole:
      return std::make_unique<WholeScene>(scene.measured_method);
    case Scheme::force:
      return std::make_unique<RemoteForce>(scene.measured_method, network);
    case Scheme::plane:
      return std::make_unique<RemotePlane>(scene.measured_method, network);
    case Scheme::deadband:
      return std::make_unique<RemoteDeadband>(scene.measured_method, network,
                                              RemoteDeadband::Options{.fraction = settings.deadband, .prediction = method.prediction});
    case Scheme::patch:
      return std::make_unique<RemotePatch>(scene.measured_method, scene.tiles, network,
                                           RemotePatch::Options{.source = {.bits_per_s = settings.patch_bits_per_s}});
  }
  return nullptr;
}

}  // namespace hapton
