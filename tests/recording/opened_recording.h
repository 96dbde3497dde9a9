#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "recording/recording_rows.h"
#include "tests/recording/made_recording.h"

namespace hapton {

// A MadeRecording, opened: with its index, and with its samples, which RecordingRows reads as rows.
struct OpenedRecording {
  explicit OpenedRecording(MadeRecording&& recording = MadeRecording()) : file(recording.write(scratch)), index(read()) {
    auto opened = RecordingRows::open(file, index);
    EXPECT_TRUE(opened) << opened.error().what;
    rows.emplace(std::move(*opened));
  }
  RecordingIndex read() const {
    auto reader = SessionReader::open(file);
    return *RecordingIndex::read(*reader);
  }

  ScratchFolder scratch;
  std::filesystem::path file;
  RecordingIndex index;
  std::optional<RecordingRows> rows;
};

}  // namespace hapton
