#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "core/base/result.h"

namespace hapton {

// A folder of numbered pictures, of which other programs make a video. RT: no.
class FrameFolder {
 public:
  // Makes the folder. Error: it cannot be made, or has pictures of an earlier run, which would be mixed with those of this one.
  static Result<FrameFolder> open(std::filesystem::path folder);

  // frame_000001.png and so on.
  std::filesystem::path next();
  // What is in it, and how it becomes a video.
  std::string describe(double rate_hz) const;

 private:
  explicit FrameFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path folder_;
  std::uint64_t count_ = 0;
};

}  // namespace hapton
