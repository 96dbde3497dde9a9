#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/mailbox.h"
#include "core/tool/stylus_tool.h"

namespace hapton {

// A rigid tool in two tasks: the slow one follows the device with the proxy of ToolStep, which may take milliseconds on fine meshes, and
// passes on the contacts that it finds; the fast one computes force and torque from these at the device's rate, and never waits (Ortega,
// Redon & Coquillart 2007, sections 4 and 5). A contact that the slow task has not found yet gives no force. If the slow task stalls, the
// force fades. It also fades while the proxy cannot move because more pairs are near than ToolProxy considers; after kStaleS of this, the
// tool is put where the device is. Threads: functions marked `Fast` in one thread, follow() (`Slow`) in one other. RT: the fast ones yes,
// with at most LocalContacts::kMax contacts; follow as ToolStep::step.
class HeldTool final : public StylusTool {
 public:
  // Age of the contacts at which the force begins to fade, and at which it is zero.
  static constexpr double kFreshS = 0.05;
  static constexpr double kStaleS = 0.15;
  // The hand may be deep inside something that the slow task has not found yet. If the contacts are at least twice this old, the tool is
  // therefore drawn no farther from its last collision-free pose than the distance within which contacts were searched for. Between this
  // age and twice this age, the drawn pose moves gradually to that limit.
  static constexpr double kLateS = 0.005;
  // If new contacts come more than kMaxPromptSamples samples after the previous ones and change the force by more than the device's motion
  // explains, the force fades to the new one over this time.
  static constexpr double kContactFadeS = 0.02;
  // The most time by which one sample advances this fade: after a late sample the force must not jump by what would have faded meanwhile.
  static constexpr double kMaxFadeStepS = 2e-3;
  static constexpr int kMaxPromptSamples = 2;
  // If two samples are farther apart than this, or time goes back, damping takes no motion between them into account: io_node uses no force
  // that is older than this, so the hand felt none meanwhile.
  static constexpr double kLongestGapS = 0.02;

  explicit HeldTool(std::unique_ptr<ToolStep> tool);
  // Before it is held, the tool lies at X_SP (frame S); from there it moves to the device.
  HeldTool(std::unique_ptr<ToolStep> tool, const Pose& X_SP);

  // Fast: force, torque and drawn pose for one sample, from the newest contacts. ToolOutput::proxy is that of the slow task's last step.
  ToolOutput step(const ToolInput& input, std::int64_t time_ns) noexcept override;
  // Fast: the slow task resets the proxy, as ToolStep::reset does, at the next sample.
  void begin_anew() noexcept override { ++serial_; }
  // Fast.
  void forget_motion() noexcept override { damping_.reset(); }
  // Fast: the slow task had found the tool's pose before the last step.
  bool is_known() const noexcept override { return is_known_; }
  Vec3 vertex_m() const noexcept override { return tool_->vertex_m(); }
  // Fast.
  void set_materials(const ToolMaterials& materials) noexcept override;
  // Fast: how old the contacts of the last step were.
  double age_s() const noexcept { return age_s_; }

  // Fast: counts of samples with known contacts, and of those whose contacts were so old that the force faded; the largest age. After a gap
  // between samples (kLongestGapS), counting resumes when the next contacts come.
  struct Lateness {
    std::uint64_t samples = 0;
    std::uint64_t faded = 0;
    double longest_s = 0.0;
  };
  const Lateness& lateness() const noexcept { return lateness_; }

  // Fast. The sum of what the contacts with the part exert, opposed. With friction, what their forces leave of the whole
  // (ToolFriction::list_forces) is divided among all contacts in proportion to the normal force.
  const ToolPush& push_on(std::size_t part) const noexcept override { return pushes_[part]; }

  // Slow: moves the proxy towards the newest sample and finds the contacts there. False: there is no new sample.
  bool follow() noexcept;

  const ToolStep& tool() const { return *tool_; }

 private:
  struct FoundContacts;
  bool take_found_contacts(std::int64_t time_ns) noexcept;
  void note_frozen(const FoundContacts& found, std::int64_t time_ns) noexcept;
  void count_lateness() noexcept;
  void release(const Placement& device, std::int64_t time_ns) noexcept;
  void blend(ToolOutput& output, const Placement& device, std::int64_t time_ns, bool are_late) noexcept;
  double coupling_extension(const ContactDamping::Wrench& felt) const noexcept;
  void place_objects();
  void set_friction(LocalContacts& contacts) const noexcept;
  void move_damping(const ToolInput& input, const Placement& device, double dt_s) noexcept;
  void add_damping(const LocalContacts& contacts, const LocalContacts::Solution& solution, double share, const Mat3& R_WS,
                   ToolOutput& output) noexcept;
  void find_pushes(const LocalContacts& contacts, const LocalContacts::Solution& solution, const ToolOutput& felt,
                   const Mat3& R_WS) noexcept;

  struct Sample {
    Placement device = {};
    Placement goal = {};  // what the proxy follows: the device, or where friction holds the tool
    std::int64_t time_ns = 0;
    std::uint32_t serial = 0;           // number of restarts; 0: there has been no sample
    std::vector<Placement> parts = {};  // poses of the parts of the scene that move; their number never changes
  };
  void publish(const Placement& device, const Placement& goal, std::int64_t time_ns) noexcept;
  double travel_since_last(const Sample& sample) const noexcept;
  struct FoundContacts {
    LocalContacts contacts;
    ToolProxyStep step;
    double reach = 0.0;  // local units; contacts were searched for within this distance of contacts.proxy
    std::int64_t time_ns = 0;
    std::uint32_t serial = 0;
  };
  Placement drawn_pose(const FoundContacts& found, const Placement& at) const noexcept;

  std::unique_ptr<ToolStep> tool_;  // only the slow task moves its proxy
  Mailbox<Sample> samples_;
  Mailbox<FoundContacts> found_contacts_;
  std::uint32_t serial_ = 1;
  double age_s_ = 0.0;
  double frozen_s_ = 0.0;  // how long the proxy has been unable to move
  Lateness lateness_;
  bool is_after_sample_gap_ = true;  // no contacts have come since a gap in the samples
  bool is_known_ = false;
  Sample last_sample_;  // the one that follow() used last
  std::optional<Placement> start_;
  ToolFriction friction_;
  ContactDamping damping_;
  // As set_materials() gave them, by part and object. Before its first call, contacts and damping_ have the values the tool was made with.
  std::vector<std::vector<CoulombFriction>> friction_of_;
  std::vector<std::vector<DampingCoefficients>> damping_of_;
  std::vector<std::size_t> counts_;  // of set_materials(): objects counted so far, by part
  bool has_friction_;
  bool has_changed_ = false;
  ToolView last_view_;                 // kept only if there is damping
  std::vector<Placement> parts_;       // at the fast task's last step
  std::vector<Placement> last_parts_;  // at the step before that
  std::vector<ToolPush> pushes_;
  // What the fast task's last step returned; and the change of force by late contacts, of which the share fading_share_ is still to fade.
  ContactDamping::Wrench last_wrench_;
  ContactDamping::Wrench fading_wrench_;
  double fading_share_ = 0.0;
  Placement last_device_;
  std::int64_t last_step_ns_ = 0;
  int samples_since_new_ = 0;
};

}  // namespace hapton
