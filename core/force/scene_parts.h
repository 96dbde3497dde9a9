#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/force/common_proxy.h"
#include "core/force/force_method.h"
#include "core/force/motion_groups.h"

namespace hapton {

// The objects of a scene in parts for a CommonProxy: one force method for the objects of each motion, made in the frame that moves along,
// and one for those that stand still. No method is built again when something moves. Each object that deforms (TouchObject::deformation)
// has a method of its own, a DeformingMethod, in a frame that moves along if the object moves as well; one that a program deforms
// (TouchObject::stream_reach_m) has a StreamedMethod. Each object that programs may move (TouchObject::command_pivot) has its own method,
// too; each step gets its pose (MethodInput::commanded). Objects that can be carved are in no part (SculptMethod).
//
// In the frame of a moving object the device moves even while the hand holds still. In that frame its path between two samples is taken as
// straight, and the proxy follows as usual. So a surface that moves into the hand pushes the proxy ahead and never passes it.
//
// Frame: S. Units: SI. RT: all but make, prepare, list_streamed and describe. Threads: as ForceMethod.
class SceneParts final : public FeltParts {
 public:
  using Make = Result<std::unique_ptr<ForceMethod>> (*)(const MethodSettings& settings, const TouchScene& scene);

  // make: makes the method of the objects that move or stand together. Pre: it is ProxyMethod's if something deforms. Error: whatever make,
  // DeformingMethod or StreamedMethod rejects.
  static Result<SceneParts> make(Make make, const MethodSettings& settings, const TouchScene& scene);

  std::size_t size() const noexcept { return groups_.size(); }
  // Whether there is a part that stands still. It is part 0.
  bool has_still() const noexcept { return !groups_.empty() && !groups_.front().moves(); }
  // Diagonal of the bounding box of all objects, in their shapes and places at rest, including those that can be carved.
  double extent_m() const noexcept { return extent_m_; }
  ForceMethod& method(std::size_t part) noexcept { return *groups_[part].method; }
  const std::vector<int>& objects(std::size_t part) const noexcept { return groups_[part].objects; }

  // Sets the sample for the following calls of FeltParts. The input must outlive these calls.
  void begin(const MethodInput& input) noexcept { input_ = &input; }
  Pose pose(std::size_t part) const noexcept override { return groups_[part].pose_at(*input_); }
  void reset(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept override;
  bool resume(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept override;
  MethodOutput feel(std::size_t part, const Pose& X_SO, const Vec3& p_S, const Turn& turn) noexcept override;
  StiffnessRange stiffness(std::size_t part) const noexcept override { return groups_[part].stiffness; }
  bool is_frictionless(std::size_t part) const noexcept override { return groups_[part].is_frictionless; }
  double damping(std::size_t, int object) const noexcept override { return damping_[static_cast<std::size_t>(object)]; }

  // As in ForceMethod, for all parts; `object` is the number in the scene, and materials are in the order of the scene.
  void set_materials(std::span<const Material> materials) noexcept;
  bool prepare();
  StreamedMethod* find_streamed(int object) noexcept;
  std::optional<SurfacePlace> find_place(int object) const noexcept;
  std::vector<int> list_streamed() const;
  std::string describe() const;

 private:
  // Objects with one motion.
  struct Group : MotionGroup {
    std::unique_ptr<ForceMethod> method = nullptr;
    StreamedMethod* streamed = nullptr;    // *method, where a program deforms the object
    std::vector<Material> materials = {};  // of the objects
    std::vector<Material> shared = {};     // the same, as felt while other parts hold the proxy too (shared_material)
    bool is_shared = false;                // the method now has `shared`
    StiffnessRange stiffness = {};
    bool is_frictionless = false;

    void set_materials() noexcept { method->set_materials(is_shared ? shared : materials); }
    void note_materials() noexcept;
  };

  static Result<void> make_method_of(Group& group, Make make, const MethodSettings& settings, const TouchScene& scene);

  std::vector<Group> groups_;    // in the order of group_by_motion
  std::vector<double> damping_;  // by object of the scene, N s/m
  double extent_m_ = 0.0;
  const MethodInput* input_ = nullptr;
};

}  // namespace hapton
