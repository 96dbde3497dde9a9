#include <fmt/core.h>

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/force/streamed_method.h"
#include "python/bindings.h"
#include "runtime/clock.h"

namespace hapton::python {
namespace {

// The haptic step on a surface whose shapes Python gives. Threads: any; a shape can be prepared while steps run.
class PythonDeform {
 public:
  PythonDeform(const PythonMesh& mesh, double reach_m, const Material& material) {
    Result<std::unique_ptr<StreamedMethod>> method = fail("not made");
    {
      const py::gil_scoped_release gil_released;
      method = StreamedMethod::make({}, mesh.mesh, material, reach_m);
    }
    method_ = value_or_raise(std::move(method));
  }

  double set_shape(const Doubles& vertices, double over_s);
  py::dict step(const Doubles& positions, const Doubles& dt_s);
  void reset(const Doubles& position);
  py::array_t<double> vertices();
  std::string describe() {
    const std::scoped_lock lock(step_mutex_);
    return method_->describe();
  }

 private:
  Result<double> hand_over(const std::vector<Vec3>& shape, double over_s);

  std::mutex prepare_mutex_;  // locked before step_mutex_
  std::mutex step_mutex_;
  std::unique_ptr<StreamedMethod> method_;
  bool has_begun_ = false;
  bool is_running_ = false;  // a step has run
  double time_s_ = 0.0;      // the sum of all dt_s except the first
};

// Pre: the GIL is released. The loop runs at most twice: at most one stage waits, and only that stage can begin while `shape` is prepared.
Result<double> PythonDeform::hand_over(const std::vector<Vec3>& shape, double over_s) {
  const std::scoped_lock prepare_lock(prepare_mutex_);
  for (;;) {
    std::vector<Vec3> from;
    std::uint64_t serial = 0;
    {
      const std::scoped_lock lock(step_mutex_);
      from = method_->current_stage().to;
      serial = method_->serial();
    }
    auto stage = method_->stager().make(from, shape);
    if (!stage) return tl::unexpected(stage.error());
    const double seconds = StreamedMethod::compute_time_s(**stage, over_s);
    StreamedGeometry::Released released;  // declared before the lock, so that it is destroyed after the unlocking
    const std::scoped_lock lock(step_mutex_);
    if (method_->serial() != serial) continue;
    released = method_->offer(std::move(*stage), over_s);
    return seconds;
  }
}

double PythonDeform::set_shape(const Doubles& vertices, double over_s) {
  if (!(over_s >= 0.0 && over_s <= 86'400.0))
    raise_value_error(fmt::format("over_s is {}; give at least 0 seconds, at most a day", over_s));
  const std::vector<Vec3> shape = read_points(vertices, "vertices");
  Result<double> seconds = 0.0;
  {
    const py::gil_scoped_release gil_released;
    seconds = hand_over(shape, over_s);
  }
  return value_or_raise(std::move(seconds));
}

void PythonDeform::reset(const Doubles& position) {
  const Vec3 p = read_point(position, "position");
  const std::scoped_lock lock(step_mutex_);
  method_->reset(p);
  has_begun_ = true;
}

py::array_t<double> PythonDeform::vertices() {
  std::vector<Vec3> shape;
  {
    const py::gil_scoped_release gil_released;
    const std::scoped_lock lock(step_mutex_);
    shape = method_->vertices();
  }
  py::array_t<double> array = make_points(shape.size());
  double* numbers = array.mutable_data();
  for (std::size_t v = 0; v < shape.size(); ++v) Eigen::Map<Vec3>(numbers + 3 * v) = shape[v];
  return array;
}

py::dict PythonDeform::step(const Doubles& positions, const Doubles& dt_s) {
  const std::vector<Vec3> points = read_points(positions, "positions", true);
  const auto times = static_cast<std::size_t>(dt_s.size());
  if (times != 1 && times != points.size()) {
    raise_value_error(fmt::format("dt_s has {} numbers; give one, or one for each position", times));
  }
  for (std::size_t i = 0; i < times; ++i) {
    if (!(dt_s.data()[i] > 0.0 && dt_s.data()[i] <= 1.0))
      raise_value_error(fmt::format("dt_s[{}] is {}; give seconds above 0, at most 1", i, dt_s.data()[i]));
  }
  py::array_t<double> force_n = make_points(points.size());
  py::array_t<double> proxy_m = make_points(points.size());
  py::array_t<bool> contact(static_cast<py::ssize_t>(points.size()));
  py::array_t<std::int64_t> step_ns(static_cast<py::ssize_t>(points.size()));
  double* forces = force_n.mutable_data();
  double* proxies = proxy_m.mutable_data();
  bool* contacts = contact.mutable_data();
  std::int64_t* step_times_ns = step_ns.mutable_data();
  {
    const py::gil_scoped_release gil_released;
    const SteadyClock clock;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::scoped_lock lock(step_mutex_);  // locked for each step, so that a shape can be set between two steps
      const double dt = dt_s.data()[times == 1 ? 0 : i];
      if (std::exchange(is_running_, true)) time_s_ += dt;
      if (!has_begun_ && points[i].allFinite()) {
        method_->reset(points[i]);
        has_begun_ = true;
      }
      const std::int64_t begin_ns = clock.now_ns();
      const MethodOutput felt = method_->step({.p_SD = points[i], .dt_s = dt, .time_s = time_s_});
      step_times_ns[i] = clock.now_ns() - begin_ns;
      Eigen::Map<Vec3>(forces + 3 * i) = felt.force_n;
      Eigen::Map<Vec3>(proxies + 3 * i) = felt.p_SP;
      contacts[i] = felt.contact;
    }
  }
  py::dict batch;
  batch["force_n"] = force_n;
  batch["proxy_m"] = proxy_m;
  batch["contact"] = contact;
  batch["step_ns"] = step_ns;
  return batch;
}

std::unique_ptr<PythonDeform> make_deform(const PythonMesh& mesh, double reach_m, const Material& material) {
  return std::make_unique<PythonDeform>(mesh, reach_m, material);
}

}  // namespace

void bind_deforming(py::module_& module) {
  py::class_<PythonDeform>(
      module, "DeformStep",
      "The haptic step on a surface that your program deforms: it gives the vertices of one shape after the other.\n"
      "Vertices move straight from each shape to the next, at 0.25 m/s at most, and take a probe along that they touch.")
      .def(py::init(&make_deform), py::arg("mesh"), py::arg("reach_m"), py::arg("material") = Material(),
           "mesh: the shape at rest. reach_m: no vertex may ever be farther than that from where it is at rest.")
      .def("set_shape", &PythonDeform::set_shape, py::arg("vertices"), py::arg("over_s") = 0.0,
           "The next shape, (n, 3), one for each vertex of the mesh. The surface begins to move there when the motion to the shape before "
           "has\n"
           "ended; a shape that waits is replaced by a newer one. Returns how long the motion takes: over_s, or longer if a vertex would "
           "be\n"
           "too fast. Raises ValueError, and changes nothing, if a vertex is out of reach or the surface touches itself.")
      .def("step", &PythonDeform::step, py::arg("positions"), py::arg("dt_s") = 1e-3,
           "One step for each position, (n, 3) or (3,), dt_s seconds after the one before (one number or one each). Returns a dict of\n"
           "arrays: force_n (n, 3), proxy_m (n, 3), contact (n,), step_ns (n,). Other Python threads run meanwhile, and may set a shape.")
      .def("reset", &PythonDeform::reset, py::arg("position"), "Forgets all contact and puts the probe at `position`.")
      .def_property_readonly("vertices", &PythonDeform::vertices, "The shape at the time of the last step, (n, 3).")
      .def("describe", &PythonDeform::describe, "A few lines about what was built.");
}

}  // namespace hapton::python
