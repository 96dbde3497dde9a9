// Headset in a build without OpenXR: connect() fails.
#include <utility>

#include "vision_node/xr/headset.h"

namespace hapton {

struct Headset::Runtime {
  std::string text;
  std::array<EyeInFrame, 2> eyes;
};

Result<std::unique_ptr<Headset>> Headset::connect() {
  return fail("--stereo openxr: this vision_node was built without OpenXR; install libopenxr-dev (deploy/setup does) and build it again");
}

Headset::Headset(std::unique_ptr<Runtime> runtime) : runtime_(std::move(runtime)) {}
Headset::~Headset() = default;
const std::string& Headset::name() const { return runtime_->text; }
PictureSize Headset::eye_size() const { return {}; }
Result<void> Headset::open(const GlxWindow&, RoomSpace) { return {}; }
void Headset::poll_events() {}
bool Headset::is_running() const { return false; }
bool Headset::has_ended() const { return false; }
bool Headset::is_lost() const { return true; }
const std::string& Headset::loss() const { return runtime_->text; }
bool Headset::begin_frame() { return false; }
const std::array<EyeInFrame, 2>& Headset::eyes() const { return runtime_->eyes; }
void Headset::end_frame(const CopyEye&) {}

}  // namespace hapton
