#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/force/common_proxy.h"
#include "core/force/force_method.h"
#include "core/force/motion_groups.h"

namespace hapton {

// Feels a scene in which objects move by themselves (TouchObject::motion): one method for the objects of each motion, made in the frame
// that moves along, and one for those that stand still. Nothing is built again when something moves. Each object that deforms
// (TouchObject::deformation) has a method of its own, a DeformingMethod, in the frame that moves along if it moves as well; one that a
// program deforms (TouchObject::stream_reach_m) has a StreamedMethod. Each object
// that programs may move (TouchObject::command_pivot) has a method of its own, too; where it is, the step says (MethodInput::commanded).
//
// In the frame of a moving object the device moves even while the hand holds still. Its path between two samples is taken as straight in
// that frame, and the proxy follows as usual. So a surface that moves into the hand pushes the proxy ahead and never passes it. All methods
// have one proxy (CommonProxy). A surface of speed v that comes upon a hand changes the force by stiffness times v dt in a step.
//
// Frame: S. RT: step, reset and set_materials yes. Threads: as ForceMethod.
class MovingMethod final : public ForceMethod {
 public:
  using Make = Result<std::unique_ptr<ForceMethod>> (*)(const MethodSettings&, const TouchScene&);

  // make: makes the method of the objects that move or stand together. Pre: the scene has motion; MethodOutput::p_SP of these methods is a
  // proxy; where something deforms, make is ProxyMethod's. Error: whatever make, or DeformingMethod, rejects.
  static Result<std::unique_ptr<ForceMethod>> make(Make make, const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override { proxy_.reset(p_SD); }
  void set_materials(std::span<const Material> materials) noexcept override;
  bool prepare() override;
  StreamedMethod* find_streamed(int object) noexcept override;
  std::optional<SurfacePlace> find_place(int object) const noexcept override;
  std::vector<int> list_streamed() const override;
  std::string describe() const override;

 private:
  // Objects with one motion.
  struct Group : MotionGroup {
    std::unique_ptr<ForceMethod> method = nullptr;
    StreamedMethod* streamed = nullptr;    // *method, where a program deforms the object
    std::vector<Material> materials = {};  // of the objects
    std::vector<Material> shared = {};     // the same as CommonProxy has them
    bool is_shared = false;                // the method has these
    StiffnessRange stiffness = {};

    void set_materials() noexcept { method->set_materials(is_shared ? shared : materials); }
    void note_stiffness() noexcept;
  };

  class Felt;  // the groups, in one sample

  MovingMethod(std::vector<Group> groups, double extent_m) : groups_(std::move(groups)), proxy_(groups_.size(), extent_m) {}
  static Result<void> make_method_of(Group& group, Make make, const MethodSettings& settings, const TouchScene& scene);

  std::vector<Group> groups_;  // as group_by_motion orders them
  CommonProxy proxy_;
  std::vector<double> damping_;  // by object of the scene
};

}  // namespace hapton
