#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "core/base/result.h"

namespace hapton {

// A folder of numbered pictures, from which other programs can make a video. RT: no.
class FrameFolder {
 public:
  // Makes the folder if there is none. Error: it cannot be made or read, or it has files frame_* of an earlier run: runs are not mixed.
  static Result<FrameFolder> open(std::filesystem::path folder);

  // The path of the next picture: frame_000001.png, frame_000002.png and so on, in the folder.
  std::filesystem::path next();
  // How many pictures were named, in which folder, and the command that makes a video of them with that frame rate.
  std::string describe(double rate_hz) const;

 private:
  explicit FrameFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path folder_;
  std::uint64_t count_ = 0;
};

}  // namespace hapton
