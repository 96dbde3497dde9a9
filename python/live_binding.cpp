#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "core/base/ns_between.h"
#include "core/effects/sampled_motion.h"
#include "core/force/force_method.h"
#include "core/math/rigid_pose.h"
#include "core/math/turn_by_degrees.h"
#include "python/bindings.h"
#include "python/field_node.h"
#include "python/live_client.h"
#include "scene/material_limits.h"

namespace hapton::python {
namespace {

template <class Open>
auto open_or_raise(Open&& open) {
  decltype(open()) opened = fail("not opened");
  {
    const py::gil_scoped_release gil_released;
    opened = open();
  }
  return value_or_raise(std::move(opened));
}

py::array_t<double> make_quaternion(const Quat& q) {
  py::array_t<double> array(4);
  const double numbers[] = {q.w(), q.x(), q.y(), q.z()};
  for (int k = 0; k < 4; ++k) array.mutable_at(k) = numbers[k];
  return array;
}

py::object describe_probe(LiveClient& client) {
  const std::optional<ProbeState> probe = client.newest();
  if (!probe) return py::none();
  py::dict state;
  state["sample"] = probe->sample;
  state["t_s"] = 1e-9 * static_cast<double>(probe->sample_time_ns);
  state["position_m"] = make_point(probe->p_WD);
  state["orientation"] = make_quaternion(probe->q_WT);
  state["proxy_m"] = make_point(probe->p_WD + probe->visual_offset_m);
  state["force_n"] = make_point(probe->force_n);
  state["torque_nm"] = make_point(probe->torque_nm);
  state["contact"] = probe->contact;
  state["haptons"] = probe->haptons ? py::cast(*probe->haptons) : py::none();
  state["object"] = probe->object;
  state["object_name"] = make_text(client.find_name(probe->object));
  state["buttons"] = probe->buttons;
  state["status"] = static_cast<int>(probe->status);
  state["view_revision"] = probe->view_revision;
  state["scene_time_s"] = 1e-9 * static_cast<double>(probe->scene_time_ns);
  state["servo_rate_hz"] = probe->servo_rate_hz;
  state["round_trip_p50_us"] = probe->round_trip_p50_us;
  state["round_trip_p99_us"] = probe->round_trip_p99_us;
  return state;
}

std::uint32_t turn_scene(LiveClient& client, const Doubles& scene_pose) {
  const Pose pose = read_pose(scene_pose, "scene_pose");
  std::array<float, 12> rows = {};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 4; ++k) rows[static_cast<std::size_t>(4 * i + k)] = static_cast<float>(pose.matrix()(i, k));
  }
  auto revision = [&] {
    const py::gil_scoped_release gil_released;  // turn_scene may wait for the hub's first state
    return client.turn_scene(rows);
  }();
  return value_or_raise(std::move(revision));
}

using ObjectKey = std::variant<std::int64_t, std::string>;  // number in the scene, or name

std::string name_of(const ObjectKey& key) {
  const auto* number = std::get_if<std::int64_t>(&key);
  return number != nullptr ? fmt::format("#{}", *number) : std::get<std::string>(key);
}

std::int32_t find_number(LiveClient& client, const ObjectKey& key) {
  if (const auto* number = std::get_if<std::int64_t>(&key)) {
    if (*number < 0 || *number > INT32_MAX) raise_value_error(fmt::format("there is no object {}: they are numbered from 0", *number));
    return static_cast<std::int32_t>(*number);
  }
  const std::string& name = std::get<std::string>(key);
  const KnownMoves::Named named = client.find_named(name);
  if (named.count > 1) raise_value_error(fmt::format("{} objects are named '{}': give the number of one", named.count, name));
  if (!named.object) {
    raise_value_error(
        fmt::format("no object '{}' has been announced that programs may move; client.movable_objects() lists those that have", name));
  }
  return *named.object;
}

py::object describe_object(LiveClient& client, std::int32_t number, std::optional<double> scene_time_s) {
  const auto placed = client.find_object(number, scene_time_s);
  if (!placed) return py::none();
  py::dict pose;
  pose["object"] = number;
  pose["name"] = make_text(client.find_name(number));
  pose["scene_time_s"] = placed->at.time_s;
  pose["pivot_position_m"] = make_point(placed->at.p_S);
  pose["turn"] = make_quaternion(placed->at.turn);
  pose["moving"] = placed->is_moving;
  return pose;
}

py::object object_pose(LiveClient& client, const ObjectKey& object, std::optional<double> scene_time_s) {
  if (scene_time_s && !std::isfinite(*scene_time_s)) raise_value_error("scene_time_s is not finite");
  return describe_object(client, find_number(client, object), scene_time_s);
}

py::list movable_objects(LiveClient& client) {
  py::list all;
  for (const std::int32_t number : client.movable_objects()) {
    if (py::object pose = describe_object(client, number, std::nullopt); !pose.is_none()) all.append(pose);
  }
  return all;
}

py::dict describe_carves(LiveClient& client, std::int64_t after) {
  if (after < 0 || after > UINT32_MAX) raise_value_error(fmt::format("after is {}; give the number of carves that you have", after));
  LiveClient::CarvesSoFar so_far;
  {
    const py::gil_scoped_release gil_released;
    so_far = client.find_carves(static_cast<std::uint32_t>(after));
  }
  const std::size_t count = so_far.carves.size();
  py::array_t<std::int32_t> object(static_cast<py::ssize_t>(count));
  py::array_t<double> from_m = make_points(count);
  py::array_t<double> to_m = make_points(count);
  py::array_t<double> radius_m(static_cast<py::ssize_t>(count));
  py::array_t<bool> begins(static_cast<py::ssize_t>(count));
  py::array_t<std::uint32_t> undone_first(static_cast<py::ssize_t>(count));
  py::array_t<std::uint32_t> undone_last(static_cast<py::ssize_t>(count));
  for (std::size_t n = 0; n < count; ++n) {
    const Carves::One& one = so_far.carves[n];
    begins.mutable_data()[n] = one.begins;
    undone_first.mutable_data()[n] = one.undone_first;
    undone_last.mutable_data()[n] = one.undone_last;
    object.mutable_data()[n] = one.object;
    radius_m.mutable_data()[n] = static_cast<double>(one.radius_m);
    std::copy(one.from_m.begin(), one.from_m.end(), from_m.mutable_data() + 3 * n);
    std::copy(one.to_m.begin(), one.to_m.end(), to_m.mutable_data() + 3 * n);
  }
  py::dict carves;
  carves["object"] = object;
  carves["from_m"] = from_m;
  carves["to_m"] = to_m;
  carves["radius_m"] = radius_m;
  carves["begins"] = begins;
  carves["undone_first"] = undone_first;
  carves["undone_last"] = undone_last;
  carves["newest"] = so_far.newest;
  return carves;
}

double move_object(LiveClient& client, const ObjectKey& object, const std::optional<Doubles>& position_m,
                   const std::optional<Doubles>& rotation, const std::optional<Doubles>& rotation_deg, std::optional<double> over_s) {
  MoveTarget target{.over_s = over_s};
  const auto read = [](const Doubles& numbers, const char* name, double* to, py::ssize_t count) {
    if (numbers.ndim() != 1 || numbers.shape(0) != count) raise_value_error(fmt::format("{} must be {} numbers", name, count));
    for (py::ssize_t k = 0; k < count; ++k) to[k] = numbers.at(k);
  };
  if (rotation && rotation_deg) raise_value_error("rotation and rotation_deg are given: keep one");
  if (position_m) read(*position_m, "position_m", target.position_m.emplace().data(), 3);
  if (rotation) {
    std::array<double, 4> q = {};
    read(*rotation, "rotation", q.data(), 4);
    target.rotation = Quat(q[0], q[1], q[2], q[3]);
  }
  if (rotation_deg) {
    Vec3 degrees = Vec3::Zero();
    read(*rotation_deg, "rotation_deg", degrees.data(), 3);
    target.rotation = turn_by_degrees(degrees);
  }
  const std::string object_name = name_of(object);
  auto seconds = [&] {
    const py::gil_scoped_release gil_released;
    return client.move_object(object_name, target);
  }();
  return value_or_raise(std::move(seconds));
}

std::optional<double> set_shape(LiveClient& client, const ObjectKey& object, const Doubles& displacements_m, double over_s, bool wait) {
  const std::vector<Vec3> points = read_points(displacements_m, "displacements_m");
  std::vector<ShapePart::Displacement> shape;
  shape.reserve(points.size());
  for (const Vec3& p : points) shape.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  const std::string object_name = name_of(object);
  auto seconds = [&] {
    const py::gil_scoped_release gil_released;
    return client.set_shape(object_name, shape, over_s, wait);
  }();
  const double takes_s = value_or_raise(std::move(seconds));
  return wait ? std::optional(takes_s) : std::nullopt;
}

std::string change_settings(LiveClient& client, const std::optional<std::string>& method, const std::optional<std::string>& object,
                            std::optional<double> stiffness_n_per_m, std::optional<double> damping_ns_per_m,
                            std::optional<double> friction_static, std::optional<double> friction_dynamic, std::optional<double> rate_hz,
                            const std::string& key_file) {
  SettingsChange change;
  const auto give = [&](const std::optional<double>& value, const MaterialLimit& limit, std::uint32_t bit, double& into) {
    if (!value) return;
    if (const auto fits = check_number(limit, limit.key, *value); !fits) raise_value_error(fits.error().what);
    change.material.fields |= bit;
    into = *value;
  };
  give(stiffness_n_per_m, kStiffnessLimit, MaterialChange::kStiffness, change.material.stiffness_n_per_m);
  give(damping_ns_per_m, kDampingLimit, MaterialChange::kDamping, change.material.damping_ns_per_m);
  give(friction_static, kFrictionStaticLimit, MaterialChange::kFrictionStatic, change.material.friction_static);
  give(friction_dynamic, kFrictionDynamicLimit, MaterialChange::kFrictionDynamic, change.material.friction_dynamic);
  if (object && change.material.fields == 0) {
    raise_value_error(fmt::format("nothing to set for object '{}'; give a stiffness, damping or friction", *object));
  }
  if (rate_hz && !(*rate_hz >= kMinServoRateHz && *rate_hz <= kMaxServoRateHz)) {
    raise_value_error(fmt::format("rate_hz is {}; give {} to {}", *rate_hz, kMinServoRateHz, kMaxServoRateHz));
  }
  if (method && !is_method_name(*method) && *method != "plugin") {
    raise_value_error(fmt::format("method '{}' is not known; choose one of: {}, or plugin", *method, method_names()));
  }
  if (change.material.fields == 0 && !rate_hz && !method) {
    raise_value_error("nothing to set; give method, rate_hz, a stiffness, damping or friction");
  }
  change.method = method.value_or("");
  change.object = object.value_or("");
  change.rate_hz = rate_hz.value_or(0.0);
  auto in_use = [&] {
    const py::gil_scoped_release gil_released;
    return client.set(change, key_file);
  }();
  return value_or_raise(std::move(in_use));
}

py::dict describe_node(FieldNode& node) {
  const FieldNodeState node_state = node.state();
  py::dict state;
  state["sample"] = node_state.sample;
  state["t_s"] = node_state.t_s;
  state["position_m"] = make_point(node_state.p_WD);
  state["velocity_m_per_s"] = make_point(node_state.v_WD);
  state["force_n"] = make_point(node_state.force_n);
  state["buttons"] = node_state.buttons;
  state["joined"] = node_state.is_joined;
  state["replies"] = node_state.replies;
  state["answers"] = node_state.replies;  // former name of "replies"
  state["superseded"] = node_state.superseded;
  state["changes"] = node_state.changes;
  state["changed_sample"] = node_state.changed_sample;
  state["watch_over"] = node_state.has_watch_expired;
  state["rate_hz"] = node_state.rate_hz;
  state["compute_p50_us"] = node_state.compute_p50_us;
  state["compute_p99_us"] = node_state.compute_p99_us;
  return state;
}

// The argument of a force function.
struct HandSample {
  std::uint64_t sample = 0;
  double t_s = 0.0;
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  Vec3 v_WD = Vec3::Zero();
  std::uint32_t buttons = 0;
};

Vec3 read_force(const py::object& returned, std::uint64_t sample) {
  Vec3 force_n;
  try {
    const auto numbers = returned.cast<Doubles>();
    if (numbers.ndim() != 1 || numbers.shape(0) != 3) raise_value_error("another shape");
    for (int k = 0; k < 3; ++k) force_n[k] = numbers.at(k);
  } catch (const std::exception&) {
    raise_value_error(fmt::format("the force function did not return three numbers at sample {}; return (fx, fy, fz) in newtons", sample));
  }
  if (!force_n.allFinite()) raise_value_error(fmt::format("the force function returned a force that is not finite at sample {}", sample));
  return force_n;
}

py::dict describe_run(const NodeLink& link, double seconds) {
  py::dict report;
  report["replies"] = link.replies();
  report["answers"] = link.replies();  // former name of "replies"
  report["seconds"] = seconds;
  report["rate_hz"] = static_cast<double>(link.replies()) / seconds;
  report["superseded"] = link.superseded();
  report["compute_p50_us"] = 1e-3 * link.compute_times().quantile_ns(0.5);
  report["compute_p99_us"] = 1e-3 * link.compute_times().quantile_ns(0.99);
  report["compute_max_us"] = 1e-3 * static_cast<double>(link.compute_times().max_ns());
  return report;
}

// The last reply is a zero force, also after an exception of the function or Ctrl-C.
py::dict run_force_function(const py::function& force, double seconds, const std::string& hub, const std::string& key_file) {
  constexpr double kMaxS = 1e9;  // the limit of the nodes' flag --seconds
  if (!(seconds > 0.0 && seconds <= kMaxS))
    raise_value_error(fmt::format("seconds is {}; give a time above 0, at most {:g}", seconds, kMaxS));
  const std::unique_ptr<NodeLink> link = open_or_raise([&] { return NodeLink::open(hub, key_file); });
  const std::int64_t begin_ns = link->clock().now_ns();
  const std::int64_t end_ns = begin_ns + static_cast<std::int64_t>(1e9 * seconds);
  SampledMotion motion;
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  try {
    while (link->clock().now_ns() < end_ns) {
      std::optional<DeviceState> state;
      {
        const py::gil_scoped_release gil_released;
        state = link->next(link->clock().now_ns() + 20 * kNanosecondsPerMillisecond);
      }
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!state) continue;
      if (first_ns == 0) first_ns = last_ns = state->sample_time_ns;
      const std::int64_t passed_ns = ns_between(last_ns, state->sample_time_ns);
      if (passed_ns < 0) first_ns += passed_ns;  // the hub's clock has stepped back: time goes on from the sample before
      motion.add(state->p_WD, 1e-9 * static_cast<double>(passed_ns));
      last_ns = state->sample_time_ns;
      const HandSample hand{state->sample, 1e-9 * static_cast<double>(last_ns - first_ns), state->p_WD, state->q_WT, motion.velocity(),
                            state->buttons};
      link->reply(read_force(force(hand), state->sample));
    }
  } catch (...) {
    link->release();
    throw;
  }
  (void)link->next(0);  // counts the samples since the last reply
  const py::dict report = describe_run(*link, 1e-9 * static_cast<double>(link->clock().now_ns() - begin_ns));
  link->release();
  return report;
}

void bind_client_objects(py::class_<LiveClient>& bound) {
  bound
      .def("move_object", &move_object, py::arg("object"), py::arg("position_m") = py::none(), py::kw_only(),
           py::arg("rotation") = py::none(), py::arg("rotation_deg") = py::none(), py::arg("over_s") = py::none(),
           "Moves an object that has moved_by = \"program\" in the scene file, in over_s seconds, and returns the time that it takes: "
           "longer "
           "where\n"
           "a point of it would be faster than 0.25 m/s; without over_s as fast as that. object: its name, or its number. position_m and "
           "rotation\n"
           "(w, x, y, z) or rotation_deg: as in the scene file; what is left out stays. A newer request takes over from where the object "
           "is.")
      .def(
          "set_shape", &set_shape, py::arg("object"), py::arg("displacements_m"), py::arg("over_s") = 0.0, py::kw_only(),
          py::arg("wait") = false,
          "Gives an object that has deformed_by = \"program\" in the scene file its next shape: displacements_m, (n, 3), of each vertex of "
          "its mesh\n"
          "from where it is at rest, in m of the mesh, before scale and pose. The surface moves there in over_s seconds, or longer where a "
          "vertex\n"
          "would be faster than 0.25 m/s, once it has arrived at the shape before. Returns at once: of shapes that wait, the newest is "
          "sent, "
          "and one\n"
          "that gets lost is left out (take_shape_rejection() says why the object did not take one). wait: sends it until it has arrived, "
          "and "
          "returns\n"
          "the time that the motion takes; use it for the last shape. object: its name, or its number.")
      .def(
          "take_shape_rejection", [](LiveClient& client) { return make_text(client.take_shape_rejection()); },
          "Why the object did not take the newest shape of those that it rejected since the last call; empty: it took all.")
      .def("object_pose", &object_pose, py::arg("object"), py::arg("scene_time_s") = py::none(),
           "Where an object is that programs may move, as a dict: object (its number), scene_time_s, pivot_position_m (of its pivot, frame "
           "S), "
           "turn\n"
           "(w, x, y, z; about the pivot, from the object as the scene file places it), moving, name. At the sample of state(), or at "
           "scene_time_s.\n"
           "object: its number or its name. None: not announced yet, or programs may not move it.")
      .def("movable_objects", &movable_objects,
           "All objects that programs may move, as far as they have been announced: a list of dicts as of object_pose, at the sample of "
           "state().")
      .def("carves", &describe_carves, py::arg("after") = 0,
           "What the stylus has carved, in its order, as a dict of arrays: object, from_m and to_m (n, 3), radius_m: material within "
           "radius_m of the\n"
           "segment is removed, in the frame of the object as the scene file places it. begins: the first carve of a press of the button.\n"
           "undone_first, undone_last: of an undo, whose object is -1: the entries, counted from 1, that count no longer; 0: a carve.\n"
           "after: leave out so many, those that you have. "
           "newest: how many\n"
           "haptics_node has announced. Fewer than before: it was started again, and the objects are whole.");
}

void bind_client(py::module_& module) {
  py::class_<LiveClient> bound(module, "Client", "Sees a running session: where the hand is, what it feels, which buttons are down.");
  bound
      .def(py::init([](const std::string& hub, const std::string& key_file) {
             return open_or_raise([&] { return LiveClient::open(hub, key_file); });
           }),
           py::arg("hub") = "127.0.0.1", py::arg("key_file") = "",
           "hub: HOST or HOST:PORT of io_node. key_file: of the role vision; empty: this user's key.")
      .def("state", &describe_probe,
           "The newest sample as a dict: sample, t_s, position_m, orientation (w, x, y, z), proxy_m, force_n, torque_nm, contact, haptons "
           "(of a rigid tool; else None), object, "
           "object_name\n"
           "(of those that programs may move; else empty), buttons, status, view_revision, scene_time_s, servo_rate_hz, round_trip_p50_us, "
           "round_trip_p99_us. None before the first. A few hundred a "
           "second at most.")
      .def("turn_scene", &turn_scene, py::arg("scene_pose"),
           "Moves what is touched: (4, 4), pose of the scene in W. Returns its revision; state()['view_revision'] reaches it when the "
           "forces do.")
      .def_property_readonly("joined", &LiveClient::is_joined, "A hub replies.")
      .def(
          "mark",
          [](LiveClient& client, const std::string& text) {
            auto sample = [&] {
              const py::gil_scoped_release gil_released;
              return client.mark(text);
            }();
            return value_or_raise(std::move(sample));
          },
          py::arg("text"),
          "Marks the recording (io_node --record) at the newest sample and returns that sample's number. text: 1 to 160 bytes of UTF-8 in "
          "one line.\n"
          "Raises where nothing is recorded, or above 50 markers a second.");
  bind_client_objects(bound);
  bound
      .def("set", &change_settings, py::kw_only(), py::arg("method") = py::none(), py::arg("object") = py::none(),
           py::arg("stiffness_n_per_m") = py::none(), py::arg("damping_ns_per_m") = py::none(), py::arg("friction_static") = py::none(),
           py::arg("friction_dynamic") = py::none(), py::arg("rate_hz") = py::none(), py::arg("key_file") = "",
           "Changes the force method, the material of an object (object: its name; without it of all) or the servo rate while they are "
           "felt, as\n"
           "`hapton set` does. What is not given stays. Returns what is in use then, when hub and haptics_node have confirmed it; raises "
           "with the\n"
           "reason otherwise. key_file: of the role tool, where the client's own is of the role vision alone.")
      .def("close", &LiveClient::stop, py::call_guard<py::gil_scoped_release>(), "Leaves the session.");
}

void bind_force_function(py::module_& module) {
  py::class_<HandSample>(module, "HandSample", "A sample of the device. Frame W, SI units.")
      .def_readonly("sample", &HandSample::sample)
      .def_readonly("t_s", &HandSample::t_s, "Since the first sample.")
      .def_property_readonly("position_m", [](const HandSample& hand) { return make_point(hand.p_WD); })
      .def_property_readonly(
          "orientation", [](const HandSample& hand) { return make_quaternion(hand.q_WT); }, "w, x, y, z")
      .def_property_readonly("velocity_m_per_s", [](const HandSample& hand) { return make_point(hand.v_WD); })
      .def_readonly("buttons", &HandSample::buttons);
  module.def("run_haptics_node", &run_force_function, py::arg("force"), py::arg("seconds"), py::arg("hub") = "127.0.0.1",
             py::arg("key_file") = "",
             "Is the haptics node of a session: calls force(hand: HandSample) for each newest sample and sends the (fx, fy, fz) that it "
             "returns, N.\n"
             "Returns what was measured: replies, seconds, rate_hz, superseded (samples that came while Python was busy), compute_p50_us,\n"
             "compute_p99_us, compute_max_us. An exception ends it, after a force of zero.");
}

}  // namespace

std::unique_ptr<FieldNode> open_field_node(const std::string& hub, const std::string& key_file, std::optional<double> watch_s) {
  if (watch_s && !(*watch_s > 0.0)) raise_value_error(fmt::format("watch_s is {}; give a time above 0, or None", *watch_s));
  auto link = open_or_raise([&] { return NodeLink::open(hub, key_file); });
  return std::make_unique<FieldNode>(std::move(link), watch_s.value_or(std::numeric_limits<double>::infinity()));
}

std::optional<std::uint64_t> set_fields(FieldNode& node, const py::iterable& fields, const std::optional<std::string>& mark) {
  if (const auto accepted = node.set(read_fields(fields)); !accepted) raise_value_error(accepted.error().what);
  if (!mark) return std::nullopt;
  auto sample = [&] {
    const py::gil_scoped_release gil_released;
    return node.mark(*mark);
  }();
  return value_or_raise(std::move(sample));
}

void bind_live(py::module_& module) {
  bind_client(module);
  bind_force_function(module);
  py::class_<FieldNode>(module, "FieldNode",
                        "A haptics node whose C++ thread replies to every sample with a sum of fields; set() changes them.")
      .def(py::init(&open_field_node), py::arg("hub") = "127.0.0.1", py::arg("key_file") = "", py::arg("watch_s") = py::none(),
           "hub: HOST or HOST:PORT of io_node. key_file: of the role haptics; empty: this user's key. watch_s: the force fades to zero "
           "while\n"
           "Python has called neither set nor state for that long; None: the fields stay until close, or the end of Python.")
      .def("set", &set_fields, py::arg("fields"), py::arg("mark") = py::none(),
           "The fields from now on, all changed at one sample; the force fades to theirs within 0.1 s. Their times begin at 0.\n"
           "mark: also marks the recording (io_node --record) once they are in use, waits for it, and returns the number of the marked "
           "sample.")
      .def("state", &describe_node,
           "The newest sample as a dict: sample, t_s, position_m, velocity_m_per_s, force_n (requested), buttons, joined, replies, "
           "superseded,\n"
           "changes (of the fields), changed_sample (the first with the present fields), watch_over (no force, see watch_s), rate_hz, "
           "compute_p50_us, compute_p99_us.")
      .def("close", &FieldNode::stop, py::call_guard<py::gil_scoped_release>(), "Releases the force and leaves the session.")
      .def("__enter__", [](py::object node) { return node; })
      .def("__exit__", [](FieldNode& node, const py::args&) {
        const py::gil_scoped_release gil_released;
        node.stop();
      });
}

}  // namespace hapton::python
