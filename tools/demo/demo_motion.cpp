#include "tools/demo/demo_motion.h"

#include <unordered_map>
#include <variant>

#include "recording/recording_entries.h"

namespace hapton {
namespace {

// Joins the forces with their samples.
class MotionReader {
 public:
  void add(const SessionEntry& entry, const Datagram* datagram) {
    if (entry.kind == SessionEntry::Kind::cycle) motion_.written_forces.push_back({entry.time_ns, entry.cycle.written_n.norm()});
    if (datagram == nullptr) return;
    if (const auto* state = std::get_if<DeviceState>(&datagram->message); state != nullptr && entry.kind == SessionEntry::Kind::sent) {
      devices_[state->sample] = {state->sample_time_ns, state->p_WD};
    }
    const auto* force = std::get_if<ForceCommand>(&datagram->message);
    if (force == nullptr || entry.kind != SessionEntry::Kind::received) return;
    if (const auto device = devices_.find(force->echo_sample); device != devices_.end()) {
      const auto& [time_ns, p_WD] = device->second;
      motion_.steps.push_back({time_ns, p_WD, p_WD + force->visual_offset_m, force->force_n, force->contact});
    }
  }
  DemoMotion take() { return std::move(motion_); }

 private:
  struct Sampled {
    std::int64_t time_ns;
    Vec3 p_WD;
  };
  std::unordered_map<std::uint64_t, Sampled> devices_;
  DemoMotion motion_;
};

}  // namespace

Result<DemoMotion> read_demo_motion(const std::filesystem::path& recording) {
  auto reader = SessionReader::open(recording);
  if (!reader) return tl::unexpected(reader.error());
  MotionReader motion;
  (void)for_each_entry(*reader, [&](const SessionEntry& entry, const Datagram* datagram) -> Result<void> {
    motion.add(entry, datagram);
    return {};
  });
  if (auto ended = check_end(*reader); !ended) return tl::unexpected(ended.error());
  return motion.take();
}

}  // namespace hapton
