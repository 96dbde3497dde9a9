#include <fmt/core.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "core/force/touch_step.h"
#include "python/bindings.h"
#include "python/method_keywords.h"
#include "runtime/clock.h"
#include "scene/find_scene.h"
#include "scene/material_limits.h"
#include "scene/scene_file.h"

namespace hapton::python {
namespace {

Material make_material(double stiffness_n_per_m, double damping_ns_per_m, double friction_static, double friction_dynamic, bool two_sided) {
  const Material material{stiffness_n_per_m, damping_ns_per_m, friction_static, friction_dynamic, two_sided};
  if (const auto fits = check_material(material, Material(), SurfaceEffects(), "Material"); !fits) raise_value_error(fits.error().what);
  return material;
}

// The results of a batch of steps, one entry for each position.
struct Batch {
  explicit Batch(std::size_t count)
      : force_n(make_points(count)),
        proxy_m(make_points(count)),
        contact(static_cast<py::ssize_t>(count)),
        object(static_cast<py::ssize_t>(count)),
        carve(static_cast<py::ssize_t>(count)),
        step_ns(static_cast<py::ssize_t>(count)) {}

  py::dict to_dict() const {
    py::dict batch;
    batch["force_n"] = force_n;
    batch["proxy_m"] = proxy_m;
    batch["contact"] = contact;
    batch["object"] = object;
    batch["carve"] = carve;
    batch["step_ns"] = step_ns;
    return batch;
  }

  py::array_t<double> force_n;
  py::array_t<double> proxy_m;
  py::array_t<bool> contact;
  py::array_t<std::int32_t> object;
  py::array_t<std::uint32_t> carve;  // serial of the carve that the step made; 0: it made none
  py::array_t<std::int64_t> step_ns;
};

// Raises an error unless there is one number for all positions, or one for each.
void check_count(py::ssize_t size, std::size_t positions, const char* name) {
  const auto count = static_cast<std::size_t>(size);
  if (count == 1 || count == positions) return;
  raise_value_error(fmt::format("{} has {} numbers; give one, or one for each position", name, count));
}

// One haptic step and what it remembers from sample to sample. Threads: any; one batch at a time.
class PythonTouch {
 public:
  PythonTouch(const TouchScene& scene, const MethodSettings& settings) {
    Result<std::unique_ptr<ForceMethod>> method = fail("not made");
    {
      const py::gil_scoped_release gil_released;
      method = make_method(settings, scene);
    }
    touch_ = std::make_unique<TouchStep>(value_or_raise(std::move(method)), scene);
  }

  py::dict step(const Doubles& positions, const Doubles& dt_s, const std::optional<Doubles>& scene_pose, const Doubles& buttons);
  void reset(const Doubles& position, const std::optional<Doubles>& scene_pose);
  std::string describe() const { return touch_->method().describe(); }

 private:
  void prepare(const TouchInput& input);

  std::mutex mutex_;
  std::unique_ptr<TouchStep> touch_;
  bool has_begun_ = false;
  bool is_running_ = false;  // a step has run
  double time_s_ = 0.0;      // scene time: the sum of all dt_s except the first
};

// Pre: the caller holds mutex_.
void PythonTouch::prepare(const TouchInput& input) {
  touch_->reset(input);
  has_begun_ = true;
}

void PythonTouch::reset(const Doubles& position, const std::optional<Doubles>& scene_pose) {
  const TouchInput input{.p_WD = read_point(position, "position"),
                         .X_WS = scene_pose ? read_pose(*scene_pose, "scene_pose") : Pose::Identity()};
  const py::gil_scoped_release gil_released;
  const std::scoped_lock lock(mutex_);
  prepare(input);
}

py::dict PythonTouch::step(const Doubles& positions, const Doubles& dt_s, const std::optional<Doubles>& scene_pose,
                           const Doubles& buttons) {
  const std::vector<Vec3> points = read_points(positions, "positions", true);
  const auto times = static_cast<std::size_t>(dt_s.size());
  check_count(dt_s.size(), points.size(), "dt_s");
  check_count(buttons.size(), points.size(), "buttons");
  for (py::ssize_t i = 0; i < buttons.size(); ++i) {
    const double down = buttons.data()[i];
    if (!(down >= 0.0 && down <= UINT32_MAX && down == std::floor(down)))
      raise_value_error(fmt::format("buttons[{}] is {}; give a whole number of 32 bits, one for each button that is down", i, down));
  }
  for (std::size_t i = 0; i < times; ++i) {
    if (!(dt_s.data()[i] > 0.0 && dt_s.data()[i] <= 1.0))
      raise_value_error(fmt::format("dt_s[{}] is {}; give seconds above 0, at most 1", i, dt_s.data()[i]));
  }
  TouchInput input;
  if (scene_pose) input.X_WS = read_pose(*scene_pose, "scene_pose");
  Batch batch(points.size());
  double* force_n = batch.force_n.mutable_data();
  double* proxy_m = batch.proxy_m.mutable_data();
  bool* contact = batch.contact.mutable_data();
  std::int32_t* object = batch.object.mutable_data();
  std::uint32_t* carve = batch.carve.mutable_data();
  std::int64_t* step_ns = batch.step_ns.mutable_data();
  {
    const py::gil_scoped_release gil_released;
    const std::scoped_lock lock(mutex_);
    const SteadyClock clock;
    for (std::size_t i = 0; i < points.size(); ++i) {
      input.p_WD = points[i];
      input.dt_s = dt_s.data()[times == 1 ? 0 : i];
      input.buttons = static_cast<std::uint32_t>(buttons.data()[buttons.size() == 1 ? 0 : static_cast<py::ssize_t>(i)]);
      if (std::exchange(is_running_, true)) time_s_ += input.dt_s;
      input.time_s = time_s_;
      if (!has_begun_ && points[i].allFinite()) prepare(input);
      const std::int64_t begin_ns = clock.now_ns();
      const TouchOutput output = touch_->step(input);
      step_ns[i] = clock.now_ns() - begin_ns;
      Eigen::Map<Vec3>(force_n + 3 * i) = output.force_n;
      Eigen::Map<Vec3>(proxy_m + 3 * i) = points[i] + output.visual_offset_m;
      contact[i] = output.contact;
      object[i] = output.object;
      const MadeCarve* made = touch_->made_carve();
      carve[i] = made != nullptr ? made->serial : 0;
    }
  }
  return batch.to_dict();
}

std::unique_ptr<PythonTouch> make_touch(const py::object& objects, const Material& material, const std::string& method,
                                        const py::kwargs& settings) {
  return std::make_unique<PythonTouch>(read_objects(objects, material), read_method(method, settings));
}

std::unique_ptr<PythonTouch> make_from_scene(const std::string& path, const std::optional<std::string>& unit, bool fit,
                                             const std::string& method, const py::kwargs& settings) {
  const MethodSettings read = read_method(method, settings);
  SceneLoading loading;
  if (unit) loading.unit = value_or_raise(parse_unit(*unit));
  loading.fit = fit ? MeshFit::workspace : MeshFit::off;
  Result<Scene> scene = fail("not loaded");
  {
    const py::gil_scoped_release gil_released;
    scene = load_scene(find_scene(path), loading);
  }
  const Scene loaded = value_or_raise(std::move(scene));
  warn_of_libraries(loaded);
  return std::make_unique<PythonTouch>(loaded.touch_scene(), read);
}

}  // namespace

void warn_of_libraries(const Scene& scene) {
  for (const LibraryEffect& named : scene.libraries) {
    if (PyErr_WarnEx(PyExc_UserWarning, named.describe().c_str(), 2) != 0) throw py::error_already_set();
  }
}

TouchScene read_objects(const py::object& objects, const Material& material) {
  TouchScene scene;
  const auto add = [&](const py::handle& object) {
    if (py::isinstance<PythonMesh>(object)) {
      scene.objects.push_back({object.cast<PythonMesh>().mesh, material});
    } else if (py::isinstance<py::tuple>(object) && py::len(object) == 2 && py::isinstance<PythonMesh>(object[py::int_(0)]) &&
               py::isinstance<Material>(object[py::int_(1)])) {
      scene.objects.push_back({object[py::int_(0)].cast<PythonMesh>().mesh, object[py::int_(1)].cast<Material>()});
    } else {
      raise_value_error("objects has something else than a Mesh or a pair (Mesh, Material)");
    }
  };
  if (py::isinstance<PythonMesh>(objects)) {
    add(objects);
  } else {
    for (const py::handle& object : objects) add(object);
  }
  return scene;
}

void bind_touch(py::module_& module) {
  py::class_<Material>(module, "Material", "What a surface feels like. SI units.")
      .def(py::init(&make_material), py::arg("stiffness_n_per_m") = 1000.0, py::arg("damping_ns_per_m") = 0.0,
           py::arg("friction_static") = 0.0, py::arg("friction_dynamic") = 0.0, py::arg("two_sided") = true)
      .def_readonly("stiffness_n_per_m", &Material::stiffness_n_per_m)
      .def_readonly("damping_ns_per_m", &Material::damping_ns_per_m)
      .def_readonly("friction_static", &Material::friction_static)
      .def_readonly("friction_dynamic", &Material::friction_dynamic)
      .def_readonly("two_sided", &Material::two_sided);
  py::class_<PythonTouch>(module, "TouchStep",
                          "The haptic step of haptics_node: positions of the device in, forces out. It remembers contact.")
      .def(py::init(&make_touch), py::arg("objects"), py::arg("material") = Material(), py::arg("method") = "proxy",
           "objects: a Mesh, or a list of Mesh or (Mesh, Material). method: see hapton.methods(). Further keywords are the method's "
           "settings,\n"
           "such as probe_radius_m=0.001; docs/python.md lists them.")
      .def_static(
          "from_scene", &make_from_scene, py::arg("path"), py::arg("unit") = py::none(), py::arg("fit") = false,
          py::arg("method") = "proxy",
          "From a scene file with its materials and effects, or from a mesh file in `unit`. fit: into the workspace, as haptics_node does\n"
          "with a mesh file.")
      .def("step", &PythonTouch::step, py::arg("positions"), py::arg("dt_s") = 1e-3, py::arg("scene_pose") = py::none(),
           py::arg("buttons") = 0,
           "One step for each of the (n, 3) positions (frame W, metres), dt_s seconds apart. scene_pose: (4, 4), of the scene in W.\n"
           "buttons: of the stylus that are down, a bit each, one number or one for each position; they carve bodies with sculpt = true, "
           "and "
           "start effects.\n"
           "Returns a dict of arrays: force_n (n, 3), proxy_m (n, 3), contact (n,), object (n,) (-1: none), carve (n,) (the serial of what "
           "the step carved;\n"
           "0: nothing), step_ns (n,).\n"
           "The first position of all is taken to be in free space. Other Python threads run meanwhile.")
      .def("reset", &PythonTouch::reset, py::arg("position"), py::arg("scene_pose") = py::none(),
           "Forgets all contact and puts the probe at `position` in free space.")
      .def("describe", &PythonTouch::describe, "A few lines about what was built.");
  module.def("methods", &list_methods, "The names of the force methods.");
}

}  // namespace hapton::python
