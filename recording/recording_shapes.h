#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/result.h"
#include "link/codec.h"
#include "link/session_reader.h"
#include "recording/shape_index.h"

namespace hapton {

// Reads the vertices of shapes from a recording when they are shown: a shape of 10,000 vertices is spread over 40 ms of the file. RT: no.
// Threads: one.
class RecordingShapes {
 public:
  // Error: see SessionReader::open.
  static Result<RecordingShapes> open(const std::filesystem::path& file);

  // The parts of this shape that the recording has; empty if it has none. Pre: `shape` comes from an index of the same file.
  std::vector<ObjectShape> read(const IndexedShape& shape);

 private:
  explicit RecordingShapes(SessionReader reader) : reader_(std::make_unique<SessionReader>(std::move(reader))) {}

  std::unique_ptr<SessionReader> reader_;
  Codec codec_;
};

}  // namespace hapton
