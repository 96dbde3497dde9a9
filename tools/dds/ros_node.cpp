#include "tools/dds/ros_node.h"

#ifdef HAPTON_WITH_DDS

#include <dds/dds.h>
#include <ros2_messages.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/period_ns.h"
#include "core/math/rotation_vector.h"
#include "tools/dds/ros_names.h"

namespace hapton::dds {
namespace {

using Header = std_msgs_msg_dds__Header_;
using Pose = geometry_msgs_msg_dds__PoseStamped_;
using Twist = geometry_msgs_msg_dds__TwistStamped_;
using WrenchMessage = geometry_msgs_msg_dds__WrenchStamped_;
using Transform = geometry_msgs_msg_dds__TransformStamped_;
using Transforms = tf2_msgs_msg_dds__TFMessage_;
using Joy = sensor_msgs_msg_dds__Joy_;

constexpr std::size_t kButtons = 32;               // bits of ProbeState::buttons
constexpr std::int64_t kJoyEveryNs = 100'000'000;  // period without a change, for programs that join later
constexpr std::size_t kMaxForces = 16;             // most forces taken at a time; only the newest takes effect, so older ones may be lost
constexpr int kSensorDepth = 5;                    // queue depth of rmw_qos_profile_sensor_data
constexpr int kReliableDepth = 10;                 // queue depth of ROS 2's default profile
constexpr int kTransformDepth = 100;               // queue depth of tf2's broadcaster

// Keeps what the DDS engine logs before a call fails, as this says more than the return code. Threads of the engine log, too.
class EngineLog {
 public:
  void clear() {
    const std::scoped_lock lock(mutex_);
    text_.clear();
  }
  void add(std::string_view line) {
    const std::scoped_lock lock(mutex_);
    if (text_.size() < kMax) text_ += line;
    std::replace(text_.begin(), text_.end(), '\n', ' ');
  }
  std::string text() {
    const std::scoped_lock lock(mutex_);
    return text_;
  }

 private:
  static constexpr std::size_t kMax = 400;  // characters; no line is added to a longer text; a free choice
  std::mutex mutex_;
  std::string text_;
};
EngineLog engine_log;

void keep_log(void*, const dds_log_data_t* data) { engine_log.add({data->message, data->size}); }

template <class... Args>
tl::unexpected<Error> engine_error(fmt::format_string<Args...> what, Args&&... args) {
  std::string log = engine_log.text();
  while (!log.empty() && log.back() == ' ') log.pop_back();
  return fail("{}{}{}", fmt::format(what, std::forward<Args>(args)...), log.empty() ? "" : ": ", log);
}

// What a participant without multicast needs to find others on this host: it asks each port at which one may listen, every second.
constexpr std::string_view kAskThisHost =
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>50</MaxAutoParticipantIndex>"
    "<SPDPInterval>1s</SPDPInterval><Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>";
constexpr std::string_view kLoopbackInterface = "<NetworkInterface address=\"127.0.0.1\" multicast=\"false\"/>";

std::string configure(std::string_view interfaces, bool is_this_host) {
  return fmt::format("<CycloneDDS><Domain><General><Interfaces>{}</Interfaces>{}</General>{}</Domain></CycloneDDS>", interfaces,
                     is_this_host ? "<AllowMulticast>false</AllowMulticast>" : "", is_this_host ? kAskThisHost : "");
}

// The configurations to try in turn. Programs with the default settings of ROS 2 give an address of the network as theirs, not loopback,
// even to participants on this host; without a network only loopback exists.
std::vector<std::string> make_configurations(const std::string& interface) {
  constexpr std::string_view kAuto = "<NetworkInterface autodetermine=\"true\"/>";
  if (interface.empty()) return {configure(fmt::format("{}{}", kLoopbackInterface, kAuto), true), configure(kLoopbackInterface, true)};
  if (interface == "auto") return {configure(kAuto, false)};
  if (interface == "lo" || interface.starts_with("127.")) return {configure(kLoopbackInterface, true)};
  const bool is_address = interface.find_first_not_of("0123456789.") == std::string::npos || interface.find(':') != std::string::npos;
  return {configure(fmt::format("<NetworkInterface {}=\"{}\"/>", is_address ? "address" : "name", interface), false)};
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

Qos make_qos(bool is_reliable, int depth) {
  Qos qos(dds_create_qos());
  // Writing never waits for a reader.
  dds_qset_reliability(qos.get(), is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &xcdr1);
  return qos;
}

template <class Vector>
Vector vector_of(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
geometry_msgs_msg_dds__Quaternion_ quaternion_of(const Quat& q) { return {q.x(), q.y(), q.z(), q.w()}; }

}  // namespace

struct RosNode::State {
  Options options;
  std::string device_frame;
  std::string proxy_frame;
  dds_entity_t domain = 0;  // 0: this object created none
  dds_entity_t participant = 0;
  dds_entity_t pose_writer = 0;
  dds_entity_t proxy_writer = 0;
  dds_entity_t twist_writer = 0;
  dds_entity_t wrench_writer = 0;
  dds_entity_t joy_writer = 0;
  dds_entity_t tf_writer = 0;
  dds_entity_t servo_reader = 0;
  std::array<std::int32_t, kButtons> buttons = {};
  std::uint32_t button_bits = 0;
  std::int64_t next_joy_ns = 0;
  std::int64_t next_tf_ns = 0;
  PublishCounts counts;

  ~State() {
    if (participant > 0) dds_delete(participant);
    if (domain > 0) dds_delete(domain);
    dds_set_log_sink(nullptr, nullptr);
    dds_set_trace_sink(nullptr, nullptr);
  }

  Result<void> join();
  Result<void> make_topics();
  Result<dds_entity_t> make_topic(const dds_topic_descriptor_t& type, const std::string& ros_name) const;
  Result<void> make_writer(dds_entity_t& writer, const dds_topic_descriptor_t& type, const std::string& ros_name,
                           const dds_qos_t* qos) const;

  void write(dds_entity_t writer, const void* message) {
    ++(dds_write(writer, message) == DDS_RETCODE_OK ? counts.written : counts.failed);
  }
  Header header(std::int64_t stamp_ns) {
    return {{static_cast<std::int32_t>(stamp_ns / 1'000'000'000), static_cast<std::uint32_t>(stamp_ns % 1'000'000'000)},
            options.frame.data()};
  }
  Transform transform(const Header& header, std::string& child, const Vec3& p, const Quat& q) {
    return {header, child.data(), {vector_of<geometry_msgs_msg_dds__Vector3_>(p), quaternion_of(q)}};
  }
  bool is_due(std::int64_t& next_ns, std::int64_t every_ns, std::int64_t stamp_ns) {
    // If the time of day was set back, everything is due.
    if (stamp_ns < next_ns && next_ns - stamp_ns <= every_ns) return false;
    next_ns = next_ns + every_ns > stamp_ns && next_ns <= stamp_ns ? next_ns + every_ns : stamp_ns + every_ns;
    return true;
  }
};

Result<void> RosNode::State::join() {
  engine_log.clear();
  dds_set_log_sink(keep_log, nullptr);
  dds_set_trace_sink(keep_log, nullptr);
  const auto id = static_cast<dds_domainid_t>(options.domain);
  const char* uri = std::getenv("CYCLONEDDS_URI");
  const bool is_configured = options.interface.empty() && uri != nullptr && *uri != '\0';
  if (!is_configured) {
    for (const std::string& configuration : make_configurations(options.interface)) {
      engine_log.clear();
      domain = dds_create_domain(id, configuration.c_str());
      if (domain > 0) break;
    }
    if (domain < 0) {
      return engine_error("no DDS domain {} on network interface {} (`ip address` lists them)", options.domain,
                          options.interface.empty() ? "127.0.0.1" : options.interface);
    }
  }
  const Qos qos(dds_create_qos());
  // ROS 2 looks for this text in a participant: "/" is the name for no enclave of its security.
  constexpr std::string_view kEnclave = "enclave=/;";
  dds_qset_userdata(qos.get(), kEnclave.data(), kEnclave.size());
  participant = dds_create_participant(id, qos.get(), nullptr);
  if (participant < 0) {
    return engine_error("DDS domain {} cannot be joined{}", options.domain, is_configured ? " as CYCLONEDDS_URI configures it" : "");
  }
  return make_topics();
}

Result<dds_entity_t> RosNode::State::make_topic(const dds_topic_descriptor_t& type, const std::string& ros_name) const {
  const dds_entity_t topic = dds_create_topic(participant, &type, dds_topic(ros_name).c_str(), nullptr, nullptr);
  if (topic < 0) return engine_error("topic {}: {}", ros_name, dds_strretcode(topic));
  return topic;
}

Result<void> RosNode::State::make_writer(dds_entity_t& writer, const dds_topic_descriptor_t& type, const std::string& ros_name,
                                         const dds_qos_t* qos) const {
  const auto topic = make_topic(type, ros_name);
  if (!topic) return tl::unexpected(topic.error());
  writer = dds_create_writer(participant, *topic, qos, nullptr);
  if (writer < 0) return engine_error("writing topic {}: {}", ros_name, dds_strretcode(writer));
  return {};
}

Result<void> RosNode::State::make_topics() {
  const Qos sensor = make_qos(options.is_reliable, options.is_reliable ? kReliableDepth : kSensorDepth);
  const Qos transforms = make_qos(true, kTransformDepth);
  struct Writer {
    dds_entity_t& entity;
    const dds_topic_descriptor_t& type;
    std::string name;
    const dds_qos_t* qos;
  };
  const Writer writers[] = {
      {wrench_writer, geometry_msgs_msg_dds__WrenchStamped__desc, options.prefix + "/measured_cf", sensor.get()},
      {pose_writer, geometry_msgs_msg_dds__PoseStamped__desc, options.prefix + "/measured_cp", sensor.get()},
      {twist_writer, geometry_msgs_msg_dds__TwistStamped__desc, options.prefix + "/measured_cv", sensor.get()},
      {proxy_writer, geometry_msgs_msg_dds__PoseStamped__desc, options.prefix + "/proxy/measured_cp", sensor.get()},
      {joy_writer, sensor_msgs_msg_dds__Joy__desc, options.prefix + "/joy", sensor.get()},
      {tf_writer, tf2_msgs_msg_dds__TFMessage__desc, "/tf", transforms.get()},
  };
  for (const Writer& writer : writers) {
    if (&writer.entity == &tf_writer && options.tf_rate_hz <= 0.0) continue;
    if (const auto made = make_writer(writer.entity, writer.type, writer.name, writer.qos); !made) return made;
  }
  if (!options.takes_forces) return {};
  const auto topic = make_topic(geometry_msgs_msg_dds__WrenchStamped__desc, options.prefix + "/servo_cf");
  if (!topic) return tl::unexpected(topic.error());
  servo_reader = dds_create_reader(participant, *topic, make_qos(false, kMaxForces).get(), nullptr);
  if (servo_reader < 0) return engine_error("reading topic {}/servo_cf: {}", options.prefix, dds_strretcode(servo_reader));
  return {};
}

RosNode::RosNode(std::unique_ptr<State> state) : state_(std::move(state)) {}
RosNode::~RosNode() = default;

Result<std::unique_ptr<RosNode>> RosNode::open(const Options& options) {
  auto state = std::make_unique<State>();
  state->options = options;
  state->device_frame = options.prefix.substr(1) + "/device";
  state->proxy_frame = options.prefix.substr(1) + "/proxy";
  if (const auto joined = state->join(); !joined) return tl::unexpected(joined.error());
  return std::unique_ptr<RosNode>(new RosNode(std::move(state)));
}

const PublishCounts& RosNode::counts() const noexcept { return state_->counts; }

void RosNode::publish(const RosSample& sample) {
  State& state = *state_;
  const ProbeState& probe = sample.probe;
  const Header header = state.header(sample.stamp_ns);
  using Vector = geometry_msgs_msg_dds__Vector3_;
  using Point = geometry_msgs_msg_dds__Point_;

  const WrenchMessage wrench = {header, {vector_of<Vector>(probe.force_n), vector_of<Vector>(probe.torque_nm)}};
  state.write(state.wrench_writer, &wrench);
  const Pose pose = {header, {vector_of<Point>(probe.p_WD), quaternion_of(probe.q_WT)}};
  state.write(state.pose_writer, &pose);
  const Twist twist = {header, {vector_of<Vector>(sample.linear_m_per_s), vector_of<Vector>(sample.angular_rad_per_s)}};
  state.write(state.twist_writer, &twist);

  const Vec3 p_WP = probe.p_WD + probe.visual_offset_m;
  const Quat q_WP = turn_by(probe.visual_turn) * probe.q_WT;
  const Pose proxy = {header, {vector_of<Point>(p_WP), quaternion_of(q_WP)}};
  state.write(state.proxy_writer, &proxy);

  if (probe.buttons != state.button_bits || state.is_due(state.next_joy_ns, kJoyEveryNs, sample.stamp_ns)) {
    state.button_bits = probe.buttons;
    for (std::size_t i = 0; i < kButtons; ++i) state.buttons[i] = static_cast<std::int32_t>(probe.buttons >> i & 1U);
    Joy joy = {};
    joy.header_ = header;
    joy.buttons_ = {kButtons, kButtons, state.buttons.data(), false};
    state.write(state.joy_writer, &joy);
  }
  if (state.options.tf_rate_hz <= 0.0) return;
  if (!state.is_due(state.next_tf_ns, period_ns(state.options.tf_rate_hz), sample.stamp_ns)) return;
  std::array<Transform, 2> both = {state.transform(header, state.device_frame, probe.p_WD, probe.q_WT),
                                   state.transform(header, state.proxy_frame, p_WP, q_WP)};
  const Transforms transforms = {{both.size(), both.size(), both.data(), false}};
  state.write(state.tf_writer, &transforms);
}

void RosNode::take_forces(const std::function<void(const ServoCommand&)>& visit) {
  std::array<void*, kMaxForces> messages = {};
  std::array<dds_sample_info_t, kMaxForces> infos;
  const dds_return_t count = dds_take(state_->servo_reader, messages.data(), infos.data(), messages.size(), messages.size());
  for (dds_return_t i = 0; i < count; ++i) {
    if (!infos[i].valid_data) continue;
    const auto& message = *static_cast<const WrenchMessage*>(messages[i]);
    const auto& force = message.wrench_.force_;
    const auto& torque = message.wrench_.torque_;
    visit({.writer = infos[i].publication_handle,
           .frame_id = message.header_.frame_id_ == nullptr ? "" : message.header_.frame_id_,
           .force_n = {force.x_, force.y_, force.z_},
           .torque_nm = {torque.x_, torque.y_, torque.z_}});
  }
  if (count > 0) dds_return_loan(state_->servo_reader, messages.data(), count);
}

}  // namespace hapton::dds

#else  // without DDS the command still exists, and says what to install

namespace hapton::dds {

struct RosNode::State {
  PublishCounts counts;
};

RosNode::RosNode(std::unique_ptr<State> state) : state_(std::move(state)) {}
RosNode::~RosNode() = default;
Result<std::unique_ptr<RosNode>> RosNode::open(const Options&) {
  return fail("this hapton was built without DDS; install cyclonedds-dev and cyclonedds-tools (deploy/setup does) and build it again");
}
void RosNode::publish(const RosSample&) {}
const PublishCounts& RosNode::counts() const noexcept { return state_->counts; }
void RosNode::take_forces(const std::function<void(const ServoCommand&)>&) {}

}  // namespace hapton::dds

#endif
