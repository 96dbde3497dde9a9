#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "session/session_rows.h"
#include "tests/session/made_recording.h"

namespace hapton {

// A made recording with its index and rows.
struct OpenedRecording {
  explicit OpenedRecording(MadeRecording&& recording = MadeRecording()) : file(recording.write(scratch)), index(read()) {
    auto opened = SessionRows::open(file, index);
    EXPECT_TRUE(opened) << opened.error().what;
    rows.emplace(std::move(*opened));
  }
  SessionIndex read() const {
    auto reader = SessionReader::open(file);
    return *SessionIndex::read(*reader);
  }

  ScratchFolder scratch;
  std::filesystem::path file;
  SessionIndex index;
  std::optional<SessionRows> rows;
};

}  // namespace hapton
