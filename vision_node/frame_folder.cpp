#include "vision_node/frame_folder.h"

#include <fmt/format.h>

namespace hapton {

Result<FrameFolder> FrameFolder::open(std::filesystem::path folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail("--frames {}: the folder cannot be made: {}", folder.string(), error.message());
  for (std::filesystem::directory_iterator file(folder, error), end; !error && file != end; file.increment(error)) {
    if (file->path().filename().string().starts_with("frame_")) {
      return fail("--frames {}: has {} of an earlier run; name a new or empty folder", folder.string(), file->path().filename().string());
    }
  }
  if (error) return fail("--frames {}: the folder cannot be read: {}", folder.string(), error.message());
  return FrameFolder(std::move(folder));
}

std::filesystem::path FrameFolder::next() { return folder_ / fmt::format("frame_{:06}.png", ++count_); }

std::string FrameFolder::describe(double rate_hz) const {
  return fmt::format("{} pictures in {}; for a video: ffmpeg -framerate {:g} -i {}/frame_%06d.png -pix_fmt yuv420p video.mp4", count_,
                     folder_.string(), rate_hz, folder_.string());
}

}  // namespace hapton
