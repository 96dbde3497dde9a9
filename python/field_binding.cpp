#include <fmt/core.h>

#include "python/bindings.h"
#include "python/fields.h"

namespace hapton::python {
namespace {

constexpr double kMaxNumber = 1e6;
constexpr double kMaxMassKg = 5.0;  // this limit and the next are those of scene files
constexpr double kMaxFilterS = 1.0;

// What a field object of Python holds: one of several force laws.
struct PythonField {
  Field law;
};

double check_number(double value, const char* name, bool may_be_zero = true) {
  if (!(value <= kMaxNumber && (may_be_zero ? value >= 0.0 : value > 0.0))) {
    raise_value_error(fmt::format("{} is {}; give {} 0, at most {}", name, value, may_be_zero ? "at least" : "more than", kMaxNumber));
  }
  return value;
}

Vec3 read_direction(const Doubles& array, const char* name) {
  const Vec3 direction = read_point(array, name);
  if (!(direction.norm() > 1e-9)) raise_value_error(fmt::format("{} is zero; give a direction", name));
  return direction.normalized();
}

PythonField make_spring(const Doubles& centre, double stiffness, double max_force_n) {
  return {
      SpringEffect{read_point(centre, "centre_m"), check_number(stiffness, "stiffness_n_per_m"), check_number(max_force_n, "max_force_n")}};
}

PythonField make_viscous(double damping, double max_force_n) {
  ViscousEffect law;
  law.damping_ns_per_m = check_number(damping, "damping_ns_per_m");
  law.max_force_n = check_number(max_force_n, "max_force_n");
  return {law};
}

PythonField make_mass(double mass_kg, double filter_s, double max_force_n) {
  if (!(filter_s >= MassEffect::kMinFilterS && filter_s <= kMaxFilterS)) {
    raise_value_error(fmt::format("filter_s is {}; give at least {} s, at most {}", filter_s, MassEffect::kMinFilterS, kMaxFilterS));
  }
  if (!(mass_kg >= 0.0 && mass_kg <= kMaxMassKg))
    raise_value_error(fmt::format("mass_kg is {}; give at least 0, at most {}", mass_kg, kMaxMassKg));
  MassField field;
  field.law = {.mass_kg = mass_kg, .filter_s = filter_s, .max_force_n = check_number(max_force_n, "max_force_n")};
  return {field};
}

PythonField make_constant(const Doubles& force) {
  ConstantEffect law;
  law.force_n = read_point(force, "force_n");
  return {law};
}

PythonField make_sine(const Doubles& direction, double amplitude_n, double frequency_hz) {
  WaveEffect law;
  law.direction = read_direction(direction, "direction");
  law.amplitude_n = check_number(amplitude_n, "amplitude_n");
  law.frequency_hz = check_number(frequency_hz, "frequency_hz");
  return {law};
}

PythonField make_wall(const Doubles& point, const Doubles& normal, double stiffness, double damping, double max_force_n) {
  return {WallField{read_point(point, "point_m"), read_direction(normal, "normal"), check_number(stiffness, "stiffness_n_per_m"),
                    check_number(damping, "damping_ns_per_m"), check_number(max_force_n, "max_force_n")}};
}

PythonField make_channel(const Doubles& point, const Doubles& direction, double stiffness, double damping, double max_force_n) {
  return {ChannelField{read_point(point, "point_m"), read_direction(direction, "direction"), check_number(stiffness, "stiffness_n_per_m"),
                       check_number(damping, "damping_ns_per_m"), check_number(max_force_n, "max_force_n")}};
}

PythonField make_pulse(const Doubles& force, double duration_s, double delay_s) {
  return {PulseField{read_point(force, "force_n"), check_number(duration_s, "duration_s", false), check_number(delay_s, "delay_s")}};
}

PythonField make_expression(const std::string& fx, const std::string& fy, const std::string& fz, double max_force_n,
                            const py::kwargs& constants) {
  std::map<std::string, double> numbers;
  for (const auto& [name, value] : constants) {
    try {
      numbers[name.cast<std::string>()] = value.cast<double>();
    } catch (const py::cast_error&) {
      raise_value_error(fmt::format("the constant {} is not a number", name.cast<std::string>()));
    }
  }
  auto made = ExpressionField::make({fx, fy, fz}, numbers, check_number(max_force_n, "max_force_n"));
  if (!made) raise_value_error(made.error().what);
  return {std::move(*made)};
}

std::vector<Field> laws_of(const std::vector<PythonField>& fields) {
  std::vector<Field> laws;
  for (const PythonField& field : fields) laws.push_back(field.law);
  return laws;
}

py::array_t<double> evaluate_fields(const std::vector<PythonField>& fields, const Doubles& positions, double dt_s) {
  const std::vector<Vec3> points = read_points(positions, "positions", true);
  check_number(dt_s, "dt_s", false);
  py::array_t<double> forces = make_points(points.size());
  double* force_n = forces.mutable_data();
  {
    const py::gil_scoped_release gil_released;
    FieldLaw law(laws_of(fields));
    for (std::size_t i = 0; i < points.size(); ++i) Eigen::Map<Vec3>(force_n + 3 * i) = law.step(points[i], i == 0 ? 0.0 : dt_s);
  }
  return forces;
}

}  // namespace

std::vector<Field> read_fields(const py::iterable& fields) {
  std::vector<Field> laws;
  for (const py::handle& field : fields) {
    if (!py::isinstance<PythonField>(field)) raise_value_error("fields contains something that is not a field; see hapton.fields");
    laws.push_back(field.cast<PythonField>().law);
  }
  return laws;
}

void bind_fields(py::module_& module) {
  py::module_ fields = module.def_submodule("fields", "Forces by formula, for FieldNode. Frame W, SI units. Each is bounded.");
  py::class_<PythonField>(fields, "Field", "A force by formula; made by the functions of this module.");
  fields.def("spring", &make_spring, py::arg("centre_m"), py::arg("stiffness_n_per_m"), py::arg("max_force_n") = 5.0, "-k (p - centre).");
  fields.def("viscous", &make_viscous, py::arg("damping_ns_per_m"), py::arg("max_force_n") = 5.0, "-b v.");
  fields.def("mass", &make_mass, py::arg("mass_kg"), py::arg("filter_s") = 0.02, py::arg("max_force_n") = 5.0,
             "-m a, the acceleration behind a low-pass of filter_s: a mass that the hand tows through a damper of m / filter_s.");
  fields.def("constant", &make_constant, py::arg("force_n"), "The same force everywhere.");
  fields.def("sine", &make_sine, py::arg("direction"), py::arg("amplitude_n"), py::arg("frequency_hz"),
             "amplitude sin(2 pi f t) along a direction.");
  fields.def("wall", &make_wall, py::arg("point_m"), py::arg("normal"), py::arg("stiffness_n_per_m") = 800.0,
             py::arg("damping_ns_per_m") = 0.0, py::arg("max_force_n") = 5.0,
             "Behind the plane through point_m: (k depth - b v . n) n, never inwards. normal: to the free side.");
  fields.def("channel", &make_channel, py::arg("point_m"), py::arg("direction"), py::arg("stiffness_n_per_m") = 400.0,
             py::arg("damping_ns_per_m") = 0.0, py::arg("max_force_n") = 5.0,
             "A spring and a damper to the sides of a line, nothing along it.");
  fields.def("pulse", &make_pulse, py::arg("force_n"), py::arg("duration_s") = 0.1, py::arg("delay_s") = 0.0,
             "A half sine of force_n, once, delay_s after the fields were set.");
  fields.def(
      "expression", &make_expression, py::arg("fx"), py::arg("fy"), py::arg("fz"), py::arg("max_force_n") = 5.0,
      "A force by three expressions of x, y, z (m), vx, vy, vz (m/s) and t (s, since the fields were set), with constants by keyword:\n"
      "expression('-k * x', '0', '-b * vz', k=40, b=2). Operators and functions of muParser; where it is not finite there is no force.");
  fields.def("evaluate", &evaluate_fields, py::arg("fields"), py::arg("positions"), py::arg("dt_s") = 1e-3,
             "The sum of fields along (n, 3) positions, dt_s seconds apart: (n, 3), N. What FieldNode would ask for, without fading.");
}

}  // namespace hapton::python
