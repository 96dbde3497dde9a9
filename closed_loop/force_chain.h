#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "closed_loop/force_law.h"
#include "link/fault_injector.h"
#include "safety/command_filter.h"
#include "safety/safety_governor.h"

namespace hapton {

// An additional stage between the accepted force and the motors, such as a passivity controller. RT: yes.
class ForceStage {
 public:
  virtual ~ForceStage() = default;
  // Called after the device was read.
  virtual void observe(const Vec3& p_WD, std::int64_t now_ns) noexcept = 0;
  // Returns the force to write now in place of `force_n`.
  virtual Vec3 shape(const Vec3& force_n, std::int64_t now_ns) noexcept = 0;
  // Called with the force that was written, after saturation.
  virtual void note_written(const Vec3& /*force_n*/) noexcept {}
};

// Computes the force on a device's motors from its position, through: encoder, link to the force law and back, command filter or governor,
// saturation. The command filter and the governor are the ones that io_node runs. Samples and forces travel as datagrams do: they may be
// late, lost or overtaken, and both sides use only the newest. Time is simulated, so no call waits. Units: SI, times in ns. Frame: W. RT:
// no. Threads: one.
class ForceChain {
 public:
  // How commands become forces. newest: the newest command is held indefinitely, as linear theory assumes. filter: the command filter of
  // io_node holds it for at most 20 ms. governor: the governor of io_node, with all its stages.
  enum class Gate : std::uint8_t { newest, filter, governor };

  struct Options {
    double encoder_step_m = 0.0;
    double max_force_n = 0.0;  // 0: unlimited
    LinkFaults to_law = {};    // faults of the link from device to force law
    LinkFaults from_law = {};
    std::uint64_t seed = 1;
    Gate gate = Gate::newest;
    DeviceLimits limits = {};  // limits of the governor
    ForceStage* stage = nullptr;
  };

  struct Counters {
    std::uint64_t samples = 0;
    std::uint64_t lost = 0;       // packets lost in both directions
    std::uint64_t overtaken = 0;  // packets that arrived after a newer one or twice, in both directions
    std::uint64_t replies = 0;
  };

  // Pre: the law and the stage outlive the chain.
  ForceChain(ForceLaw& law, const Options& options);

  // Reads the device at now_ns and sends its sample; then receives what is due and writes the force. Pre: now_ns never decreases from one
  // call of sample or receive to the next.
  void sample(const Vec3& p_WD, std::int64_t now_ns);
  // Receives all packets that are due by now_ns, in the order in which they are due.
  void receive(std::int64_t now_ns);
  // The time at which the next packet is due; none if no packet is in transit.
  std::optional<std::int64_t> next_ns() const noexcept;

  // The force on the motors now.
  const Vec3& force_n() const noexcept { return force_n_; }
  const Counters& counters() const noexcept { return counters_; }
  const SafetyGovernor* governor() const noexcept { return governor_ ? &*governor_ : nullptr; }

 private:
  struct Packet {
    std::int64_t due_ns = 0;
    std::int64_t sample_ns = 0;
    Vec3 value = Vec3::Zero();  // position of a sample, or force of a reply
    bool is_reply = false;
  };

  static bool is_later(const Packet& a, const Packet& b) noexcept;
  void send(const Packet& packet, FaultInjector& link, std::int64_t now_ns);
  void reply(const Packet& packet, std::int64_t now_ns);
  void accept(const Packet& packet, std::int64_t now_ns);
  void write(const Vec3& accepted_n, std::int64_t now_ns);
  void run_gate(const std::optional<WrenchCommand>& command, std::int64_t now_ns);

  ForceLaw& law_;
  Options options_;
  FaultInjector to_law_;
  FaultInjector from_law_;
  CommandFilter filter_;
  std::optional<SafetyGovernor> governor_;
  std::vector<Packet> packets_;  // packets in transit: a heap, the one that is due next first
  Vec3 force_n_ = Vec3::Zero();
  Vec3 newest_force_n_ = Vec3::Zero();  // force accepted last
  std::int64_t law_sample_ns_ = -1;     // newest sample that the law saw
  std::int64_t reply_sample_ns_ = -1;   // newest sample whose force came back
  Counters counters_;
};

}  // namespace hapton
