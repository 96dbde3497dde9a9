#include <fmt/core.h>

#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "core/force/space_step.h"
#include "core/tool/tool_step.h"
#include "python/bindings.h"
#include "runtime/clock.h"
#include "scene/find_scene.h"
#include "scene/find_tool.h"
#include "scene/tool_obstacles.h"

namespace hapton::python {
namespace {

// The results of a batch of steps of a tool, one entry for each pose.
struct ToolBatch {
  explicit ToolBatch(std::size_t count)
      : force_n(make_points(count)),
        torque_nm(make_points(count)),
        proxy({static_cast<py::ssize_t>(count), py::ssize_t{4}, py::ssize_t{4}}),
        contact(static_cast<py::ssize_t>(count)),
        blocked(static_cast<py::ssize_t>(count)),
        step_ns(static_cast<py::ssize_t>(count)) {}

  py::dict to_dict() const {
    py::dict batch;
    batch["force_n"] = force_n;
    batch["torque_nm"] = torque_nm;
    batch["proxy"] = proxy;
    batch["contact"] = contact;
    batch["blocked"] = blocked;
    batch["step_ns"] = step_ns;
    return batch;
  }

  py::array_t<double> force_n;
  py::array_t<double> torque_nm;
  py::array_t<double> proxy;
  py::array_t<bool> contact;
  py::array_t<bool> blocked;
  py::array_t<std::int64_t> step_ns;
};

// The step of a rigid tool and what it remembers. Threads: any; one batch at a time.
class PythonTool {
 public:
  PythonTool(const TriangleMesh& tool, const TouchScene& scene, double rotational_nm_per_rad);

  py::dict step(const Doubles& poses, const std::optional<Doubles>& scene_pose, double dt_s);
  void reset(const Doubles& pose, const std::optional<Doubles>& scene_pose);
  std::string describe() const { return tool_->describe(); }

 private:
  void place_parts();
  void add_effects(const ToolInput& input, double dt_s, ToolOutput& output) noexcept;

  std::mutex mutex_;
  std::unique_ptr<ToolStep> tool_;
  std::optional<SpaceStep> effects_;  // effects in free space; nullopt: the scene has no such effects
  std::vector<ToolPart> parts_;       // parts of the scene that can move
  std::vector<Pose> X_SO_;
  bool has_begun_ = false;
  bool is_running_ = false;  // a step has run
  double time_s_ = 0.0;      // scene time: the sum of all dt_s except the first
};

// Uses the friction, damping and viscosity of the scene's materials and the stiffness of the stiffest one, as haptics_node does.
PythonTool::PythonTool(const TriangleMesh& tool, const TouchScene& scene, double rotational_nm_per_rad) {
  if (!(rotational_nm_per_rad >= 0.0 && rotational_nm_per_rad <= 1e6)) {
    raise_value_error(fmt::format("rotational_stiffness_nm_per_rad is {}; give at least 0, at most 1e6", rotational_nm_per_rad));
  }
  ToolObstacles obstacles = make_tool_obstacles(scene);
  if (obstacles.leaves_out && PyErr_WarnEx(PyExc_UserWarning,
                                           "effects of surfaces but viscosity_ns_per_m, images, and two_sided = false are left out: of "
                                           "surfaces, a rigid tool has friction, damping and viscosity",
                                           2) != 0) {
    throw py::error_already_set();
  }
  if (scene.has_deformation()) raise_value_error("an object deforms, which a rigid tool does not support");
  parts_ = obstacles.parts;
  if (!obstacles.effects.empty()) effects_.emplace(std::move(obstacles.effects));
  X_SO_.resize(parts_.size());
  if (obstacles.meshes.empty()) raise_value_error("there are no objects; give at least one");
  const ToolCoupling coupling = {.stiffness_n_per_m = obstacles.stiffness_n_per_m,
                                 .rotational_stiffness_nm_per_rad = rotational_nm_per_rad};
  Result<std::unique_ptr<ToolStep>> made = fail("not made");
  {
    const py::gil_scoped_release gil_released;
    made = ToolStep::make(tool, std::move(obstacles.meshes), coupling, std::move(obstacles.friction), nullptr, obstacles.part_of);
  }
  tool_ = value_or_raise(std::move(made));
  if (const auto damped = tool_->damp(obstacles.damping); !damped) raise_value_error(damped.error().what);
}

void PythonTool::reset(const Doubles& pose, const std::optional<Doubles>& scene_pose) {
  ToolInput input{.X_WD = read_pose(pose, "pose"), .X_WS = scene_pose ? read_pose(*scene_pose, "scene_pose") : Pose::Identity()};
  const py::gil_scoped_release gil_released;
  const std::scoped_lock lock(mutex_);
  place_parts();
  input.X_SO = X_SO_;
  tool_->reset(input);
  if (effects_) effects_->reset();
  has_begun_ = true;
}

void PythonTool::place_parts() {
  for (std::size_t p = 0; p < parts_.size(); ++p) X_SO_[p] = parts_[p].pose_at(time_s_);
}

void PythonTool::add_effects(const ToolInput& input, double dt_s, ToolOutput& output) noexcept {
  if (!effects_) return;
  const Vec3 force_n = effects_->step({.p_WD = input.X_WD.translation(), .X_WS = input.X_WS, .dt_s = dt_s});
  output.force_n += force_n;
  output.contact = output.contact || !force_n.isZero(0.0);
}

py::dict PythonTool::step(const Doubles& poses, const std::optional<Doubles>& scene_pose, double dt_s) {
  if (!(dt_s > 0.0 && dt_s <= 1.0)) raise_value_error(fmt::format("dt_s is {}; give seconds above 0, at most 1", dt_s));
  std::vector<ToolInput> inputs;
  const Pose X_WS = scene_pose ? read_pose(*scene_pose, "scene_pose") : Pose::Identity();
  for (const Pose& X_WD : read_poses(poses, "poses")) inputs.push_back({.X_WD = X_WD, .X_WS = X_WS, .dt_s = dt_s});
  ToolBatch batch(inputs.size());
  double* force_n = batch.force_n.mutable_data();
  double* torque_nm = batch.torque_nm.mutable_data();
  double* proxy = batch.proxy.mutable_data();
  bool* contact = batch.contact.mutable_data();
  bool* blocked = batch.blocked.mutable_data();
  std::int64_t* step_ns = batch.step_ns.mutable_data();
  {
    const py::gil_scoped_release gil_released;
    const std::scoped_lock lock(mutex_);
    const SteadyClock clock;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      if (std::exchange(is_running_, true)) time_s_ += dt_s;
      place_parts();
      inputs[i].X_SO = X_SO_;
      if (!has_begun_ && inputs[i].X_WD.matrix().allFinite()) {
        tool_->reset(inputs[i]);
        has_begun_ = true;
      }
      const std::int64_t begin_ns = clock.now_ns();
      ToolOutput output = tool_->step(inputs[i]);
      add_effects(inputs[i], dt_s, output);
      step_ns[i] = clock.now_ns() - begin_ns;
      Eigen::Map<Vec3>(force_n + 3 * i) = output.force_n;
      Eigen::Map<Vec3>(torque_nm + 3 * i) = output.torque_nm;
      Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(proxy + 16 * i) = output.X_WP.matrix();
      contact[i] = output.contact;
      blocked[i] = output.proxy.is_blocked;
    }
  }
  return batch.to_dict();
}

std::unique_ptr<PythonTool> make_tool(const PythonMesh& tool, const py::object& objects, const Material& material,
                                      double rotational_nm_per_rad) {
  return std::make_unique<PythonTool>(*tool.mesh, read_objects(objects, material), rotational_nm_per_rad);
}

std::unique_ptr<PythonTool> make_tool_from_scene(const std::string& path, const std::string& tool_path,
                                                 const std::optional<std::string>& tool_unit, const std::string& grip,
                                                 const std::optional<std::string>& unit, bool fit, double rotational_nm_per_rad) {
  SceneLoading loading;
  if (unit) loading.unit = value_or_raise(parse_unit(*unit));
  loading.fit = fit ? MeshFit::workspace : MeshFit::off;
  ToolChoice choice{.file = tool_path};
  if (tool_unit) choice.unit = value_or_raise(parse_unit(*tool_unit));
  choice.grip = value_or_raise(parse_tool_grip(grip));
  Result<Scene> scene = fail("not loaded");
  Result<std::optional<SceneTool>> tool = std::optional<SceneTool>();
  {
    const py::gil_scoped_release gil_released;
    scene = load_scene(find_scene(path), loading);
    std::vector<std::string> notes;
    if (scene) tool = find_tool(choice, *scene, loading, notes);
  }
  const Scene loaded = value_or_raise(std::move(scene));
  warn_of_libraries(loaded);
  const std::optional<SceneTool> loaded_tool = value_or_raise(std::move(tool));
  if (!loaded_tool) raise_value_error(fmt::format("{} has no [tool]; give tool='FILE'", path));
  return std::make_unique<PythonTool>(*loaded_tool->mesh, loaded.touch_scene(), rotational_nm_per_rad);
}

}  // namespace

void bind_tools(py::module_& module) {
  py::class_<PythonTool>(
      module, "ToolStep",
      "The haptic step of a rigid tool, as of haptics_node --tool and hapton replay --tool: poses of the stylus in, forces and\n"
      "torques out. It remembers contact.")
      .def(py::init(&make_tool), py::arg("tool"), py::arg("objects"), py::arg("material") = Material(),
           py::arg("rotational_stiffness_nm_per_rad") = 0.0,
           "tool: a Mesh from the grip point, along the stylus' axes. objects: a Mesh, or a list of Mesh or (Mesh, Material). Its spring "
           "is as\n"
           "stiff as the stiffest material; 0 Nm/rad: from that and the tool's size.")
      .def_static("from_scene", &make_tool_from_scene, py::arg("path"), py::arg("tool") = "", py::arg("tool_unit") = py::none(),
                  py::arg("grip") = "origin", py::arg("unit") = py::none(), py::arg("fit") = false,
                  py::arg("rotational_stiffness_nm_per_rad") = 0.0,
                  "From a scene file with its [tool] and materials, or from a mesh file in `unit`; tool: the mesh file of another tool, "
                  "held at its\n"
                  "origin or its centre (grip).")
      .def("step", &PythonTool::step, py::arg("poses"), py::arg("scene_pose") = py::none(), py::arg("dt_s") = 1e-3,
           "One step for each of the (n, 4, 4) poses of the grip point in W, dt_s seconds apart: objects move by their keyframes. "
           "scene_pose: (4, 4), of the scene in W.\n"
           "Returns a dict of arrays: force_n (n, 3) and torque_nm (n, 3) about the grip point, proxy (n, 4, 4): where the tool is drawn,\n"
           "contact (n,): a surface is touched, or an effect acts, blocked (n,): it overlaps the scene since it was put there, and its "
           "contact "
           "gives no force, step_ns (n,).\n"
           "The first pose of all is where the tool is put. Other Python threads run meanwhile.")
      .def("reset", &PythonTool::reset, py::arg("pose"), py::arg("scene_pose") = py::none(),
           "Forgets all contact and puts the tool at `pose`.")
      .def("describe", &PythonTool::describe, "A few lines about what was built.");
}

}  // namespace hapton::python
